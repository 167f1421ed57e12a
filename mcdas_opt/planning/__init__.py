"""Planners: whatever answers a situation or a parking case; every answer is judged before it leaves."""

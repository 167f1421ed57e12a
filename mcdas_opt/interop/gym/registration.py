"""What gymnasium calls when it looks for environments (entry point `gymnasium.envs`), so that `gym.make("mcdas/MidVehicle-v0")` works."""

from __future__ import annotations

from mcdas_opt.errors import of_extra

ID = "mcdas/MidVehicle-v0"


def register_envs() -> None:
    """Registers our environments; called twice it changes nothing. Raises `MissingExtraError` without gymnasium."""
    with of_extra("gymnasium", "gym"):
        import gymnasium
    if ID not in gymnasium.registry:
        gymnasium.register(id=ID, entry_point="mcdas_opt.interop.gym.mid_vehicle:MidVehicle")

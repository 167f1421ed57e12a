"""Configurations of our own on the shipped networks of SUMO."""

from __future__ import annotations

from pathlib import Path

from mcdas_opt.catalogue.data_files import models_folder

NETS = models_folder() / "sumo"


def configuration(folder: Path, routes: str, net: str = "bends", end_s: float = 60.0) -> Path:
    """These routes on a shipped network."""
    (folder / "own.rou.xml").write_text(f"<routes>{routes}</routes>", "utf-8")
    text = (NETS / f"{net}.sumocfg").read_text("utf-8").replace(f'"{net}.net.xml"', f'"{NETS / net}.net.xml"')
    text = text.replace(f"{net}.rou.xml", "own.rou.xml").replace('<end value="600"/>', f'<end value="{end_s:g}"/><route-steps value="1"/>')
    (folder / "own.sumocfg").write_text(text, "utf-8")
    return folder / "own.sumocfg"

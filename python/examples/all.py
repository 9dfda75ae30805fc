"""Runs every example; its pictures go into the folder that is named."""

import pathlib
import subprocess
import sys
import time

here = pathlib.Path(__file__).parent
folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
folder.mkdir(parents=True, exist_ok=True)
for script in sorted(here.glob("*.py")):
    if script.name not in ("all.py", "terrain.py"):
        begun = time.perf_counter()
        subprocess.run([sys.executable, script, folder / f"{script.stem}.png"], check=True)
        print(f"{script.stem}.png in {time.perf_counter() - begun:.1f} s", flush=True)

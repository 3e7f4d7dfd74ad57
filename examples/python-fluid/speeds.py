"""An observer in Python: the largest speed of the bodies over time, into speeds.csv in the run's folder.

In a manifest: speeds = { program = "./speeds.py", role = "observer", lossless = true } in [components].
"""

import csv
import os

import numpy as np
import tremie


class Speeds(tremie.Observer):
    program = "speeds.py 0.1.0"

    def __init__(self, setup):
        self.path = os.path.join(setup.output, "speeds.csv")
        self.file = open(self.path, "w", newline="", encoding="utf-8")
        self.table = csv.writer(self.file)
        self.table.writerow(["window", "time [s]", "largest speed [m/s]"])
        self.rows = 0

    def bodies(self, sender, at, bodies):
        speed = np.linalg.norm(bodies["velocity"], axis=1).max(initial=0.0)
        self.table.writerow([at.window, at.time, speed])
        self.rows += 1

    def close(self, last_common_window):
        self.file.close()
        return f"{self.rows} rows in {self.path}"


if __name__ == "__main__":
    tremie.main(Speeds)

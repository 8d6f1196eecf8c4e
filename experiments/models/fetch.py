"""Data that are not kept here: Dacca, and the measles and demography of twenty towns.

`python3 fetch.py` downloads pypomp by pip, checks its hash, and writes the files beside the models. It needs
nothing but Python's standard library and pip."""

import csv
import datetime
import gzip
import hashlib
import io
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).parent
PACKAGE = "pypomp==1.1.0"
SHA256 = "24f76d9c4506a09697adbe2354b77f74be2b47407fb3300cf7ea80d38e9379aa"
FIRST, LAST = 1950, 1963


def package(wheel=None):
    """The wheel, from a file that is here or from PyPI, if it has the right hash."""
    if wheel is None:
        with tempfile.TemporaryDirectory() as folder:
            download = ["download", "--quiet", "--no-deps", "--only-binary", ":all:", "--python-version", "3.12"]
            subprocess.run([sys.executable, "-m", "pip", *download, "--dest", folder, PACKAGE], check=True)
            content = next(Path(folder).glob("*.whl")).read_bytes()
    else:
        content = Path(wheel).read_bytes()
    found = hashlib.sha256(content).hexdigest()
    if found != SHA256:
        sys.exit(f"{PACKAGE} has the hash {found}, not {SHA256}")
    return zipfile.ZipFile(io.BytesIO(content))


def rows(wheel, name):
    content = wheel.read(f"pypomp/data/{name}")
    if name.endswith(".gz"):
        content = gzip.decompress(content)
    return list(csv.DictReader(io.StringIO(content.decode())))


def write(name, header, lines):
    path = HERE / name
    path.parent.mkdir(exist_ok=True)
    with path.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(header)
        table.writerows(lines)
    print(path.relative_to(HERE))


def dacca(wheel):
    """Months are 1/12 of a year to the last digit, so that each has as many sub-steps."""
    deaths = [int(row["cholera.deaths"]) for row in rows(wheel, "dacca/dacca.csv")]
    write("dacca-cholera/data.csv", ["year", "deaths"],
          [[1891 + (month + 1) / 12, count] for month, count in enumerate(deaths)])
    times = [row["."] for row in rows(wheel, "dacca/covart.csv")]
    covariates = zip(times, rows(wheel, "dacca/covars.csv"))
    write("dacca-cholera/population.csv", ["year", "pop", "dpopdt"],
          [[time, row["pop"], row["dpopdt"]] for time, row in covariates])


def year(date):
    """Years of 365.25 days since 1950, as in the paper's programs."""
    return FIRST + (datetime.date.fromisoformat(date) - datetime.date(FIRST, 1, 1)).days / 365.25


def measles(wheel):
    """London in files of its own, and all towns that have an estimate, told apart by a column."""
    towns = [row["town"] for row in rows(wheel, "uk_measles/AK_mles.csv")]
    cases = [(row["unit"], year(row["date"]), row["cases"], row["date"])
             for row in rows(wheel, "uk_measles/measles.csv.gz") if row["unit"] in towns]
    cases = [row for row in cases if FIRST < row[1] < LAST + 1]
    # A week in which London reports none, between 82 and 58: the paper takes 76.
    cases = [(town, time, "76" if (town, date) == ("London", "1955-08-26") else count)
             for town, time, count, date in cases]
    people = [(row["unit"], row["year"], row["pop"], row["births"])
              for row in rows(wheel, "uk_measles/demog.csv") if row["unit"] in towns]
    missing = set(towns) - {row[0] for row in cases}
    if missing:
        sys.exit(f"no cases of {', '.join(sorted(missing))}")
    for name, header, table in [("data", ["year", "cases"], cases),
                                ("demography", ["year", "pop", "births"], people)]:
        write(f"london-measles/{name}.csv", header, [row[1:] for row in table if row[0] == "London"])
        write(f"london-measles/towns-{name}.csv", ["town", *header], table)


if __name__ == "__main__":
    if len(sys.argv) > 2:
        sys.exit("fetch.py [WHEEL]")
    wheel = package(*sys.argv[1:])
    dacca(wheel)
    measles(wheel)

"""Pictures of the models for [the gallery](gallery.md): figures of reports. `python3 pictures.py MOTES`, after fetch.py."""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent

K5 = ["--particles", "5000"]
EXACT = ["--proposal", "exact"]

#: Model, title of the figure that is shown, options, and what it shows.
MODELS = [
    ("london-measles", "I", K5, "Infectious people in London. A great epidemic comes every second year."),
    ("dacca-cholera", "S", K5, "People who can fall ill with cholera."),
    ("blowflies", "N[0]", ["--particles", "20000"], "Adult flies, and the cycles that come of eggs which hatch two weeks later."),
    ("influenza", "I", K5, "Infectious boys, as whole numbers."),
    ("bsflu", "I", ["--particles", "30000"], "Infectious boys, from those in bed and those who convalesce."),
    ("ricker", "log_N", K5, "The logarithm of a population with chaotic cycles."),
    ("parus", "log_N", K5, "The logarithm of the number of great tits."),
    ("sir-incidence", "I", K5, "Infectious people, from the new cases of each day."),
    ("malaria", "X", K5, "The share of women who are infected, from tests of as many as came."),
    ("leverage", "h", K5, "The log-variance of the daily returns of a dollar in euros."),
    ("federal-funds", "regime", EXACT, "The probability of the regime with high rates."),
    ("arma", "e", EXACT, "The shocks of US wholesale prices, which follow from what was measured."),
    ("co2", "level", EXACT, "Carbon dioxide over Mauna Loa without its season."),
    ("seatbelts", "level", EXACT, "The level of road casualties, apart from season, petrol and law."),
    ("quad-tank", "h3", K5, "The level of an upper tank, which is not measured."),
    ("beetle", "mode", K5, "The probability that the beetle searches."),
    ("robot", "x", K5, "A coordinate of a car among known landmarks."),
    ("bearings-only", "x", K5, "A coordinate of a target of which only the bearing is measured."),
    ("neural-decoding", "x[0]", K5, "A coordinate of a hand, from the spikes of ten neurons."),
    ("lorenz63", "x", K5, "A coordinate of Lorenz's equations."),
    ("nelson-siegel", "f[0]", EXACT, "The level of the yield curve."),
    ("quasar", "x", EXACT, "The brightness of a quasar, at the irregular times of its measurements."),
    ("fishery", "log_P", K5, "The logarithm of the biomass, as a share of what the sea can carry."),
    ("whiskers", "x", K5, "The log-odds of a spike."),
]

HEAD = """# Pictures of these models

Each picture is a figure of the report that the command above it writes; `python3 pictures.py MOTES` makes them all.
Line: mean. Band: from the 5 % to the 95 % quantile. Run the commands from this folder; `motes` stands for `cargo run --release -p motes --`.
"""


def files(name):
    """The model and its data."""
    if name == "influenza":
        return "../../examples/influenza_flows.toml", "../../examples/influenza.csv"
    return f"{name}/model.toml", "../../examples/returns.csv" if name == "leverage" else f"{name}/data.csv"


def thinned(points):
    """Of points in one column of pixels the first, the lowest, the highest and the last."""
    columns = []
    for x, y in points:
        if columns and columns[-1][0][0] == x:
            columns[-1].append((x, y))
        else:
            columns.append([(x, y)])
    kept = []
    for column in columns:
        ends = {0, len(column) - 1, *(column.index(pick(column, key=lambda at: at[1])) for pick in (min, max))}
        kept.extend(column[at] for at in sorted(ends))
    return kept


def small(svg):
    """The same picture without points that no pixel shows."""

    def shorter(found):
        points = [tuple(map(int, pair.split(","))) for pair in found[1].split()]
        return 'points="' + " ".join(f"{x},{y}" for x, y in thinned(points)) + '"'

    svg = re.sub(r'points="([-0-9, ]+)"', shorter, svg)
    return re.sub(r"\.(\d\d)\d+", r".\1", svg)


def picture(motes, name, title, options):
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.html"
        command = [motes, "filter", *files(name), *options, "--quiet", "--report", report, "-o", "/dev/null"]
        subprocess.run(command, check=True, cwd=HERE)
        page = report.read_text()
    figures = re.findall(r"<svg.*?</svg>", page, re.S)
    titles = [re.search(r"<text[^>]*>(.*?)</text>", figure, re.S)[1].strip() for figure in figures]
    if title not in titles:
        sys.exit(f"{name}: there is no figure {title}; there are {', '.join(titles)}")
    (HERE / "pictures" / f"{name}.svg").write_text(small(figures[titles.index(title)]) + "\n")
    print(name)


def page():
    """The page that shows them."""
    text = HEAD
    for name, title, options, shows in MODELS:
        command = " ".join(["motes filter", *files(name), *options, "--report", f"{name}.html"])
        text += f"\n## {name}\n\n```console\n$ {command}\n```\n\n![{title}](pictures/{name}.svg)\n\n{shows}\n"
    (HERE / "gallery.md").write_text(text)


if __name__ == "__main__":
    (HERE / "pictures").mkdir(exist_ok=True)
    for name, title, options, _ in MODELS:
        if len(sys.argv) < 3 or name in sys.argv[2:]:
            picture(sys.argv[1], name, title, options)
    page()

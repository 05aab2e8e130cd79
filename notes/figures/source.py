"""The JSON behind the figures: read, searched, and named row by row, so that each number of a CSV says where it came
from.

A reference is `bench.json#3`, the row 3 of rows (from 0), or `bench.json#machine/peaks/0`, a path from the top.
"""

import json

# The shares of the cores' time, by the names in the model's rows. The rest of 1 is time bound by memory.
SHARES = {
    "work": "work",
    "serial": "idle while one core works alone",
    "together": "forks, joins and barriers",
    "locks": "locks",
    "dispatch": "fetching chunks of loops",
    "waiting": "waiting for the slowest",
    "memory": "waiting for memory",
}


class Missing(Exception):
    """A file that a figure needs is missing, is not a report, or lacks rows."""


def load(folder, names):
    """{name: {"machine": ..., "rows": [...]}}. Each row, and each peak of the machine, has its reference as "from"."""
    data = {}
    for name in names:
        path = folder / f"{name}.json"
        try:
            report = json.loads(path.read_text())
            parts = {f"{i}": row for i, row in enumerate(report["rows"])}
            parts |= {f"machine/peaks/{i}": peak for i, peak in enumerate(report["machine"].get("peaks", []))}
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise Missing(f"{path}: cannot be read: {error}") from error
        for place, part in parts.items():
            part["from"] = f"{name}.json#{place}"
        data[name] = report
    return data


def references(*rows):
    return ",".join(dict.fromkeys(reference for r in rows for reference in r["from"].split(",")))


def rows_of(data, name, **wanted):
    """All rows in which these columns have these values; at least one."""
    found = [r for r in data[name]["rows"] if all(r.get(column) == value for column, value in wanted.items())]
    if not found:
        raise Missing(
            f"{name}.json: no row with " + ", ".join(f"{column} '{value}'" for column, value in wanted.items())
        )
    return found


def row_of(data, name, **wanted):
    return rows_of(data, name, **wanted)[0]


def first_scene(data, kernel, form, scenes, modelled="scale"):
    """The first of these scenes on which the kernel was both timed and, in the report of that name, modelled."""
    in_both = {r["scene"] for r in rows_of(data, "bench", kernel=kernel, form=form)}
    in_both &= {r["scene"] for r in rows_of(data, modelled, kernel=kernel, form=form)}
    for scene in scenes:
        if scene in in_both:
            return scene
    raise Missing(f"bench.json and {modelled}.json: '{kernel}' '{form}' on none of {', '.join(scenes)}")


def where_time_goes(row):
    """The shares of the cores' time, by SHARES; empty for what was measured."""
    if "work" not in row:
        return {}
    shares = {share: row[share] for share in SHARES if share != "memory"}
    return shares | {"memory": max(0.0, 1 - sum(shares.values()))}


def over_cores(data, kernel, form, scene):
    """Rows of one kernel over cores: measured at the thread counts of `bench`, modelled at the numbers of `curves`."""
    measured = sorted(
        rows_of(data, "bench", kernel=kernel, form=form, scene=scene, variant="openmp"), key=lambda r: r["threads"]
    )
    modelled = sorted(rows_of(data, "curves", kernel=kernel, form=form, scene=scene), key=lambda r: r["cores"])
    rows = []
    for kind, cores, ms, found in [
        ("measured", "threads", "ms", measured),
        ("modelled", "cores", "modelled_ms", modelled),
    ]:
        one = found[0]
        if one[cores] != 1:
            raise Missing(f"'{kernel}' '{form}' on {scene}: nothing {kind} on one core")
        for r in found:
            rows.append(
                {
                    "kernel": kernel,
                    "form": form,
                    "scene": scene,
                    "kind": kind,
                    "cores": r[cores],
                    "ms": r[ms],
                    "spread": r.get("spread"),
                }
                | (whole_cores(one, r) if kind == "measured" else {})
                | {"speed_up": one[ms] / r[ms], "speed_up_spread": spread_of_ratio(one, r) if r is not one else None}
                | ({"compute_speed_up": one["compute_ms"] / r["compute_ms"]} if kind == "modelled" else {})
                | where_time_goes(r)
                | {"from": references(one, r)}
            )
    return rows


def spread_of_ratio(a, b):
    """The spread of the ratio of two times, if both spreads are known: squares of relative errors add."""
    spreads = [r.get("spread") for r in (a, b)]
    return (spreads[0] ** 2 + spreads[1] ** 2) ** 0.5 if None not in spreads else None


def whole_cores(*rows):
    """The column that says whether the times behind a value had whole cores; empty where none of them says so."""
    known = [r["whole_cores"] for r in rows if "whole_cores" in r]
    return {"whole_cores": all(known)} if known else {}


def at(rows, **wanted):
    """The row of a figure with these values, or None."""
    return next((r for r in rows if all(r.get(column) == value for column, value in wanted.items())), None)


def most_cores(rows, limit=64):
    """The most cores that rows of the kind "modelled" have, up to what the papers simulate."""
    return max(r["cores"] for r in rows if r["kind"] == "modelled" and r["cores"] <= limit)


def at_most_cores(rows, **wanted):
    """The row at the most cores, up to what the papers simulate: measured if the machine has so many, else modelled."""
    most = most_cores(rows)
    return at(rows, kind="measured", cores=most, **wanted) or at(rows, kind="modelled", cores=most, **wanted)


def told(row):
    """How the number of a row over cores was found, in words."""
    return f"{row['kind']}, {row['cores']} cores" if row["cores"] > 1 else f"{row['kind']}, 1 core"


def most_measured(rows):
    """The most cores that rows of the kind "measured" have."""
    return max(r["cores"] for r in rows if r["kind"] == "measured")


def most_threads(data):
    """The most threads on which `bench` timed openmp."""
    return max(r["threads"] for r in rows_of(data, "bench", variant="openmp"))


def losses(row):
    """In words, the shares of time that are not work, largest first, without those below 5 %."""
    shares = sorted(
        ((row[share], words) for share, words in SHARES.items() if share != "work" and row[share] >= 0.05), reverse=True
    )
    return ", ".join(f"{words} {100 * share:.0f} %" for share, words in shares) or "nothing above 5 %"

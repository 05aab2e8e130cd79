"""Makes a page on which a browser shows runs of a scene: view.py PROGRAM SCENE OUT.html [--form] [--frames] [--threads]
[--variant].

Both variants run and are compared, with the verdict of `lockstep verify`; with --variant, that one alone. The page
needs no other file and no network: three.js of Debian's libjs-three is in it. See page.js for how it shows things.
"""

import argparse
import json
import os
import pathlib
import signal
import sys
import tempfile

import numpy as np

import compare
import pack
import shapes
from recording import Recording, Stopped

HERE = pathlib.Path(__file__).resolve().parent
THREE = pathlib.Path("/usr/share/javascript/three")
LICENCE = pathlib.Path("/usr/share/doc/libjs-three/copyright")


def recordings(options, folder):
    """Both runs, or one, and the row of verify; None where there is none."""
    given = [(f"--{name}", vars(options)[name]) for name in ("frames", "threads")]
    given = [word for name, value in given if value for word in (name, value)]

    def record(variant, form):
        chosen = ["--form", form] if form else []
        arguments = ["--scene", options.scene, "--variant", variant, *chosen, *given]
        return Recording(options.program, arguments, folder / variant)

    if options.variant:
        return [record(options.variant, options.form)], None
    openmp = record("openmp", options.form)
    threads = options.threads or os.cpu_count()
    row = compare.verdict(options.program, options.scene, openmp.form, openmp.kind, threads, folder / "row.json")
    # The twin with the same bits, or what a physical verdict compares whole runs with: serial's first form.
    serial = record("serial", None if row and row["verdict"] == "physical" else openmp.form)
    return [serial, openmp], row


def curves_of(runs, rows, row):
    """The curves of a page: each has lines of numbers a frame, from the frame `from`."""
    curves = []
    if rows:
        named = (("rms", "rms"), ("largest", "most"))
        lines = [{"label": label, "from": 0, "values": [r[key] for r in rows]} for label, key in named]
        for course in (row or {}).get("courses", [])[:1]:
            start = {"from": course["from"] + 1}
            since = f"verify, both from frame {course['from']}"
            lines.append({"label": f"rms, {since}"} | start | {"values": course["found"]})
            lines.append({"label": "one-ulp bound of the verdict"} | start | {"values": course["bound"]})
        curves.append({"title": "distance of openmp from serial, m", "log": True, "lines": lines})
    for name in runs[0].curves:
        lines = [{"label": run.variant, "from": 0, "values": run.curves[name]} for run in runs]
        curves.append({"title": name, "log": False, "lines": lines})
    return curves


def box_of(runs):
    """The corners of the box about all that moves, and of that in which nearly all of it stays."""
    run = runs[0]
    if run.kind in ("surface", "liquid"):
        first, points = np.array(run.grid["first"]), np.array(run.grid["points"])
        corners = first, first + run.grid["spacing"] * (points - 1)
        return corners, corners
    low = np.min([r.values[f, :, :3].min(axis=0) for r in runs for f in range(r.count)], axis=0)
    high = np.max([r.values[f, :, :3].max(axis=0) for r in runs for f in range(r.count)], axis=0)
    some = np.concatenate([run.values[f, :, :3] for f in sorted({0, run.count // 2, run.count - 1})])
    near = np.percentile(some, 2, axis=0), np.percentile(some, 98, axis=0)
    return (low.astype(np.float64), high.astype(np.float64)), near


def page_data(options, runs, row):
    """What the page knows, and its blocks: {name: [base64]}."""
    first, last = runs[0], runs[-1]
    (low, high), near = box_of(runs)
    size = float(np.linalg.norm(high - low)) or 1.0
    rows = compare.frames_of(*runs) if len(runs) == 2 else []
    same = len(runs) == 2 and compare.same_bits(*runs)
    data = {
        "scene": pathlib.Path(options.scene).stem,
        "kind": first.kind,
        "element": compare.ELEMENTS[first.kind],
        "runs": [run.name for run in runs],
        "same": same,
        "frames": first.count,
        "block": pack.FRAMES,
        "time_step": first.time_step,
        "low": low.tolist(),
        "high": high.tolist(),
        "near": [corner.tolist() for corner in near],
        "size": size,
        "rows": rows,
        "verdict": compare.in_words(row) if row else "",
        "passed": bool(row and row["passed"]),
        "verify_worst": compare.worst_of(row) if row else None,
        "curves": curves_of(runs, rows, row),
        "fixed": shapes.fixed(first),
    }
    different = len(runs) == 2 and not same
    if first.kind in ("surface", "liquid"):
        data["slice"] = shapes.slice_of(first)
        blocks = {"run0": [shapes.surface_block(first, f, low, high) for f in range(first.count)]}
        blocks["slice0"] = list(shapes.slices(first))
        if different:
            blocks["run1"] = [shapes.surface_block(last, f, low, high, (first, size)) for f in range(first.count)]
            blocks["slice1"] = list(shapes.slices(last))
    else:
        data |= shapes.fixed_shape(first, size)
        data["elements"], data["components"] = first.values.shape[1:]
        ends = [[*low, *4 * (-1.0,)], [*high, *4 * (1.0,)]] if first.kind == "bodies" else [low, high]
        blocks = {"run0": list(pack.blocks(first.values, *map(np.array, ends)))}
        if different:
            blocks["run1"] = list(pack.blocks(last.values, *map(np.array, ends), first.values))
            codes = [pack.code_of(apart, size) for apart in compare.distances(*runs)]
            blocks["apart"] = [
                pack.deflated(*(code.tobytes() for code in codes[k : k + pack.FRAMES]))
                for k in range(0, len(codes), pack.FRAMES)
            ]
    return data, blocks


def page(data, blocks):
    """The whole page; what is put into it is never put into again."""
    scripts = "\n".join(
        f'<script type="text/plain" id="{name}-{k}">{text}</script>'
        for name, texts in blocks.items()
        for k, text in enumerate(texts)
    )
    licence = LICENCE.read_text("utf-8") if LICENCE.exists() else "three.js, copyright its authors, MIT licence"
    parts = {
        "LICENCE": licence.replace("--", "- -"),
        "THREE": (THREE / "three.min.js").read_text("utf-8"),
        "CONTROLS": (THREE / "examples/js/controls/OrbitControls.js").read_text("utf-8"),
        "PAGE": "\n".join((HERE / name).read_text("utf-8") for name in ("data.js", "curves.js", "scene.js", "page.js")),
        "DATA": json.dumps(data).replace("</", "<\\/"),
        "BLOCKS": scripts,
        "TITLE": data["scene"],
    }
    template = (HERE / "page.html").read_text("utf-8")
    pieces = template.split("@@")
    return "".join(parts[piece] if k % 2 else piece for k, piece in enumerate(pieces))


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("program", type=pathlib.Path)
    arguments.add_argument("scene")
    arguments.add_argument("out", type=pathlib.Path)
    for name in ("form", "frames", "threads"):
        arguments.add_argument(f"--{name}")
    arguments.add_argument("--variant", choices=("serial", "openmp"))
    options = arguments.parse_args()
    if not THREE.exists():
        print("view: three.js is missing; as root, type: apt-get install libjs-three", file=sys.stderr)
        return 2
    options.out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=options.out.parent) as folder:
        try:
            runs, row = recordings(options, pathlib.Path(folder))
        except Stopped as stopped:
            return stopped.args[0]
        data, blocks = page_data(options, runs, row)
        options.out.write_text(page(data, blocks), "utf-8")
    print(f"{options.out}: {options.out.stat().st_size / 1e6:.1f} MB, {data['frames']} frames of {data['scene']}")
    if data["verdict"]:
        print(data["verdict"])
    if data["rows"]:
        most = max(row["most"] for row in data["rows"])
        print("all frames have the same bits" if data["same"] else f"the runs are up to {most:.3g} m apart")
    return 0


if __name__ == "__main__":
    # Frames that are on the disk are removed however it ends.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, _: sys.exit(128 + number))
    sys.exit(main())

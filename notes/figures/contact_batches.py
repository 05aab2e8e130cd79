"""The contact solver with and without contacts reordered into batches, and how large the batches are."""

import matplotlib.pyplot as plt

TITLE = "Contact solver: constraints reordered into batches"
PAPER = (
    "[ITJ07] Figure 5: with constraints in their original order the solver is at most 4 times faster on 64 cores than on one; reordered into "
    "batches without conflicts, 35 times, with the time to reorder. Simulated."
)
HERE = (
    "Speed-up over the serial solver in the original order, as measured, settled scenes, ten sweeps. The original order runs in parallel, sixteen lanes and all threads, as far as dependences let "
    "it, and keeps its bits; batches include the time to make them. Right: contacts a batch. A vector holds sixteen."
)


def draw(rows):
    figure, (speed, sizes) = plt.subplots(1, 2, figsize=(9.5, 3.6))
    for number, scene in enumerate(dict.fromkeys(r["scene"] for r in rows)):
        own = [r for r in rows if r["scene"] == scene]
        value = {(r["kind"], int(r["threads"])): float(r["value"]) for r in own if r["kind"] != "batch_size"}
        serial = value["serial_original_ms", 1]
        colour = f"C{number}"
        threads = sorted(t for kind, t in value if kind == "batches_ms")
        speed.plot(threads, [serial / value["batches_ms", t] for t in threads], marker="o", color=colour, label=f"{scene}, batches")
        speed.plot(threads, [serial / value["original_ms", t] for t in threads], marker="v", linestyle="--", color=colour, label="original order")
        batches = sorted((int(r["batch"]), float(r["value"])) for r in own if r["kind"] == "batch_size")
        sizes.step([b for b, _ in batches], [n for _, n in batches], where="mid", color=colour, label=scene)
    speed.set_xticks(threads)
    speed.set_xlabel("threads")
    speed.set_ylabel("speed-up over serial")
    speed.set_ylim(bottom=0)
    speed.legend(fontsize=6)
    sizes.axhline(16, color="black", linewidth=0.8)
    sizes.set_yscale("log")
    sizes.set_xlabel("batch")
    sizes.set_ylabel("contacts in it")
    sizes.legend(fontsize=7)
    for axis in (speed, sizes):
        axis.grid(True, alpha=0.3)
    figure.tight_layout()
    return figure

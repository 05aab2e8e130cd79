"""A frame of the production cloth, module by module: its time, and what cores would give to it."""

import sys

import module_times

TITLE = "Production cloth: a frame by module"
PAPER_FIGURE = "[ITJ07] Parallelization Methodology, Figure 8"
PAPER = (
    "5 s a frame of a production cloth, serially, on a 3.0 GHz Xeon; the size of its scene is not given. On 64"
    " simulated cores the modules of the cloth together take 1/30 of the time of one, the least of the three"
    " applications (Hughes et al., ISCA 2007)."
)
PAPER_AT_64 = 30
FORM = "batches"  # of the step
MODULES = {
    "search": "",
    "forces": "gather",
    "damping_solve": "",
    "repulsions": "batches",
    "collide_bodies": "",
    "ccd": "",
    "impulses": "batches",
    "zones": "rigid",
    "move": None,
}
KERNELS = {"search": "pairs"}  # where a module's name is not its kernel's; refitting boxes is a hundredth of the search
SCALED_ON = ["ball_92k", "ball_5k"]
NOTES = ["production_cloth", "scaling"]
REPORTS = module_times.reports("cloth_modules", "production_cloth", MODULES, KERNELS)


def table(data):
    counts = ("triangles", "steps", "iterations", "near", "impacts")
    return module_times.table(data, "cloth_modules", "production_cloth", sys.modules[__name__], counts)


def in_short(rows):
    return module_times.in_short(rows, "5 s a frame; 30x at 64 cores", f"{rows[0]['triangles']:,} triangles")


def here(rows):
    first = rows[0]
    return [
        f"A frame of 1/60 s has {first['steps']} steps, {first['iterations']} iterations of conjugate gradients and"
        f" {first['near']} contacts in all, serially. Left: the time of each module, all steps together. Right: what"
        f" the model of {first['cores']} cores gives to each on {first['modelled_on']}, a larger cloth, alone;"
        f" repulsions by their batches. {module_times.frame_in_words(rows)}"
        " The papers' time is of another machine and another scene.",
    ]


def claims(rows):
    return module_times.claims(rows, "cloth", PAPER_AT_64)


def details(rows):
    return module_times.details(rows)


def draw(rows):
    return module_times.draw(rows, PAPER_AT_64)

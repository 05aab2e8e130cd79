"""A frame of the production face, module by module: its time, and what cores would give to it."""

import sys

import module_times

TITLE = "Production face: a frame by module"
PAPER_FIGURE = "[ITJ07] Parallelization Methodology, Figure 8"
PAPER = (
    "14 s a frame of a production face, serially, on a 3.0 GHz Xeon; the size of its scene is not given. On 64"
    " simulated cores the modules of the face together take 1/50 of the time of one (Hughes et al., ISCA 2007)."
)
PAPER_AT_64 = 50
FORM = "newton"  # of the step
MODULES = {"update_state": "exact", "forces": "gather", "assemble": "", "solve": "multigrid", "move": None}
SCALED_ON = ["block_370k"]
NOTES = ["production_face", "scaling"]
REPORTS = module_times.reports("face_modules", "production_face", MODULES)


def table(data):
    return module_times.table(
        data, "face_modules", "production_face", sys.modules[__name__], ("tetrahedra", "steps", "iterations")
    )


def in_short(rows):
    return module_times.in_short(rows, "14 s a frame; 50x at 64 cores", f"{rows[0]['tetrahedra']:,} tetrahedra")


def here(rows):
    first = rows[0]
    return [
        f"A frame of 1/24 s has {first['steps']} steps of Newton's method, and {first['iterations']} iterations of"
        " conjugate gradients in all. Left: the time of each module, all steps together. Right: what the model of"
        f" {first['cores']} cores gives to each on {first['modelled_on']}, a body of about the same size, alone."
        f" {module_times.frame_in_words(rows)}"
        " The papers' time is of another machine and another scene.",
    ]


def claims(rows):
    return module_times.claims(rows, "face", PAPER_AT_64)


def details(rows):
    return module_times.details(rows)


def draw(rows):
    return module_times.draw(rows, PAPER_AT_64)

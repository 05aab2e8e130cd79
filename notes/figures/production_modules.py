"""A frame of the production fluid, module by module: its time, and what cores would give to it."""

import sys

import module_times

TITLE = "Production fluid: a frame by module"
PAPER_FIGURE = "[ITJ07] Parallelization Methodology, Figure 8"
PAPER = (
    "188 s a frame of a production fluid, serially, on a 3.0 GHz Xeon; the size of its scene is not given. On 64"
    " simulated cores the distances of the level set take 1/21 (fast marching in blocks) or 1/55 (fast sweeping) of the"
    " time of one; the modules of the fluid together 1/45 (Hughes et al., ISCA 2007)."
)
PAPER_AT_64 = 45
FORM = "multigrid"  # of the step
MODULES = {
    "time_step": "",
    "advect_level_set": "maccormack",
    "advect_particles": "",
    "advance_spray": "",
    "advect_velocity": "semi_lagrangian",
    "apply_forces": "",
    "sort_particles": "",
    "extend_level_set": "",
    "correct_level_set": "",
    "redistance": "sweeping",
    "remove_particles": "",
    "adjust_radii": "",
    "make_system": "",
    "pressure_solve": "multigrid",
    "project": "",
    "extrapolate": "",
}
SCALED_ON = ["drop_128"]
NOTES = ["production_fluid", "scaling"]
REPORTS = module_times.reports("production_modules", "production_fluid", MODULES)


def table(data):
    counts = ("cells", "particles", "substeps", "iterations")
    return module_times.table(data, "production_modules", "production_fluid", sys.modules[__name__], counts)


def in_short(rows):
    scene = f"{rows[0]['cells']:,} cells, {rows[0]['particles']:,} particles"
    return module_times.in_short(rows, "188 s a frame; 45x at 64 cores", scene)


def here(rows):
    first = rows[0]
    return [
        f"A frame of 1/24 s has {first['substeps']} substeps, and {first['iterations']} iterations of the pressure in"
        " all. Left: the time of each module, all substeps together. Right: what the model of"
        f" {first['cores']} cores gives to each on {first['modelled_on']}, alone. {module_times.frame_in_words(rows)}"
        " The papers' times are of another machine and another scene.",
    ]


def claims(rows):
    return module_times.claims(rows, "fluid", PAPER_AT_64)


def details(rows):
    return module_times.details(rows)


def draw(rows):
    return module_times.draw(rows, PAPER_AT_64)

"""Shows one form of a kernel side by side: the serial function, and the openmp function, each with what it calls of its
own file.

`make diff KERNEL=fluid/forces FORM=cell_locks` calls it. The serial side shows the form of the same name, or else the
kernel's first. A form's function is named after kernel and form (forces_cell_locks) or after the form alone (axpy).
Forms without such a function share those that begin with the kernel's name. A function of rigid/ may stand in spatial/.
Exit code 2 if there is no such kernel or form.
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile


def blocks_of(path):
    """The functions and types of a file, in order: their names, and their texts with the comments above."""
    blocks, lines, depth = [], [], 0
    for line in path.read_text().splitlines():
        if not lines and re.match(r"(#|namespace|using|}|$)", line):
            continue
        lines.append(line)
        is_code = line != "" and not line.startswith(("//", "#"))
        if is_code:
            depth += line.count("{") - line.count("}")
        if is_code and depth == 0 and line.endswith(("}", ";")):
            declaration = next(line for line in lines if not line.startswith(("//", "#", "template", "requires")))
            name = re.search(r"(?:struct|class)(?: alignas\(\w+\))? (\w+)|(\w+)\(|(\w+) =", declaration)
            blocks.append((name[name.lastindex] if name else "", "\n".join(lines)))
            lines = []
        elif depth == 0 and not line:  # the comment was the file's
            lines = []
    return blocks


def text_of(blocks, roots):
    """The blocks with these names, and those that they use."""
    wanted, found = set(), set(roots)
    while found - wanted:
        wanted |= found
        used = {word for name, text in blocks if name in wanted for word in re.findall(r"\w+", text)}
        found = wanted | {name for name, _ in blocks if name in used}
    return "\n\n".join(text for name, text in blocks if name in wanted) + "\n"


def functions(folder, kernel, form):
    """The text of a form's functions."""
    domain, name = kernel.split("/")
    files = [path for path in (pathlib.Path(folder, d, name + ".cpp") for d in (domain, "spatial")) if path.exists()]
    all_blocks = [blocks_of(path) for path in files]
    for is_named in (lambda n: n in (f"{name}_{form}", form), lambda n: n.startswith(name)):
        for blocks in all_blocks:
            if roots := [n for n, _ in blocks if n and is_named(n)]:
                return text_of(blocks, roots)
    sys.exit(f"make diff: no function of {kernel} in {files}")


def main():
    kernel, form, width = sys.argv[1:]
    rows = json.loads(subprocess.check_output(["build/lockstep", "list", "--json"]))["rows"]
    rows = {row["form"]: row for row in rows if row["kernel"] == kernel}
    own = [name for name, row in rows.items() if name and not row["covered_by"]]
    if form not in own:
        print(
            f"make diff: FORM={form} of {kernel}, expected " + (f"one of: {', '.join(own)}" if own else "none"),
            file=sys.stderr,
        )
        return 2
    serial_forms = rows[form]["serial_forms"]
    with tempfile.TemporaryDirectory() as folder:
        sides = [pathlib.Path(folder, side) for side in ("serial", "openmp")]
        for side, of_side in zip(sides, (form if form in serial_forms else serial_forms[0], form)):
            side.write_text(functions(side.name, kernel, of_side))
        subprocess.run(["diff", "--side-by-side", f"--width={width}", "--expand-tabs", *sides])
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""What the papers claim, and whether it holds here.

A figure's claims(rows) judges the claims that its numbers can answer: a row for each scene, workload or algorithm that
a claim is asked of. Every number comes from a row of the figure, so from the JSON; `from` names it.
"""

EXCEEDED, REPRODUCED, NOT = "exceeded", "reproduced", "not reproduced"
BEYOND = 1.1  # exceeded: by more than a tenth, which the model may be off by


def at_least(asked):
    """The judge of what the paper says is reached."""
    return lambda found: EXCEEDED if found > BEYOND * asked else holds(found >= asked)


def at_most(asked):
    """The judge of a cost."""
    return lambda found: EXCEEDED if BEYOND * found < asked else holds(found <= asked)


def between(low, high):
    """The judge of values that the paper gives as a range."""
    return lambda found: EXCEEDED if found > BEYOND * high else holds(found >= low)


def more_than(bound):
    """The judge of what the paper says without a number of its own to exceed."""
    return lambda found: holds(found > bound)


def within(bound):
    """The judge of what the paper says is never more than this."""
    return lambda found: holds(found <= bound)


def holds(condition):
    return REPRODUCED if condition else NOT


def claim(paper, claim, asked, judge, parts, unit=""):
    """The rows of a claim. Parts: (what it is asked of, measured or modelled on what, the number, the figure's row)."""
    return [
        {"paper": paper, "claim": claim, "asked": asked, "of": of, "how": how, "found": found, "unit": unit}
        | {"verdict": judge(found), "from": row["from"]}
        for of, how, found, row in parts
    ]


def verdict_of(parts):
    """The verdict of a claim: that of all its parts, or how many of them it holds for."""
    verdicts = [part["verdict"] for part in parts]
    if len(set(verdicts)) == 1:
        return verdicts[0]
    met = sum(verdict != NOT for verdict in verdicts)
    return f"{REPRODUCED} or {EXCEEDED}" if met == len(verdicts) else f"in part: {met} of {len(verdicts)}"

"""Small pieces of HTML, and how numbers are written."""

import html
import re


def link(target, text):
    """A cell for table() that holds a link."""
    return (f"<a href='{target}'>{html.escape(text)}</a>",)


def table(header, rows, marked=()):
    """A table of text and links; rows whose number is in `marked` stand out."""

    def line(tag, row):
        return "".join(
            f"<{tag}>{cell[0] if isinstance(cell, tuple) else html.escape(str(cell))}</{tag}>" for cell in row
        )

    body = "".join(f"<tr{' class=off' if i in marked else ''}>{line('td', row)}</tr>\n" for i, row in enumerate(rows))
    head = f"<thead><tr>{line('th', header)}</tr></thead>\n"
    return f"<div class='scroll'><table>{head}<tbody>\n{body}</tbody></table></div>\n"


def inline(svg, name):
    """An SVG file of matplotlib as a part of a page. Its ids begin with `name`, so that no two figures share one."""
    text = svg[svg.index("<svg") :]
    text = re.sub("<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(' id="', f' id="{name}-', text)
    return re.sub('(href="#|url\\(#)', rf"\1{name}-", text)


def number(value, unit=""):
    """Three digits; a dash for None."""
    if value is None:
        return "–"
    digits = f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"
    return digits + unit if unit in ("", "x") else f"{digits} {unit}"


def plain(value, _):
    """A tick of an axis, without exponent."""
    return f"{value:,.0f}" if value >= 1 and value == round(value) else f"{value:g}"


def threads(count):
    return "1 thread" if count == 1 else f"{count} threads"


def signed_percent(value):
    return "–" if value is None else f"{100 * value:+.1f} %"

"""Whether the notes are one book, and lead where they say: /usr/bin/python3 tests/notes_test.py"""

import os
import pathlib
import re
import shlex
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
NOTES = sorted((ROOT / "notes").glob("*.md"))
PAGES = [*NOTES, ROOT / "README.md", ROOT / "scenes" / "README.md"]
INDEX = ROOT / "notes" / "README.md"
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")


def headings(page):
    return [line.lstrip("# ") for line in page.read_text("utf-8").splitlines() if line.startswith("#")]


class Notes(unittest.TestCase):
    def test_every_note_is_listed_once(self):
        listed = LINK.findall(INDEX.read_text("utf-8"))
        self.assertEqual(sorted(listed), [note.name for note in NOTES if note != INDEX])
        self.assertIn("notes/README.md", LINK.findall((ROOT / "README.md").read_text("utf-8")))

    def test_links_lead_to_files(self):
        found = 0
        for page in PAGES:
            for target in LINK.findall(page.read_text("utf-8")):
                if not target.startswith("http"):
                    self.assertTrue((page.parent / target).exists(), f"{page}: {target}")
                    found += 1
        self.assertGreater(found, 50)

    def test_notes_and_headings_that_are_named_exist(self):
        """`notes/NAME.md`, and notes/NAME.md, "Heading", in pages, scenes and sources."""
        named = 0
        folders = ("common", "serial", "openmp", "verify", "tests", "scenes", "notes")
        inside = [path for folder in folders for path in (ROOT / folder).rglob("*")]
        sources = [path for path in inside if path.suffix in (".h", ".cpp", ".py", ".toml", ".md")]
        for path in [*sources, ROOT / "README.md", ROOT / "Makefile"]:
            text = re.sub(r"\n[ ]*(//|#)?[ ]*", " ", path.read_text("utf-8"))
            for name, heading in re.findall(r'\bnotes/([a-z_]+)\.md(?:\)|\]\([^)]*\)|`)?(?:, "([^"]+)")?', text):
                note = ROOT / "notes" / f"{name}.md"
                self.assertTrue(note.exists(), f"{path}: {note}")
                if heading:
                    self.assertTrue(any(h.startswith(heading) for h in headings(note)), f"{path}: {name}: {heading}")
                    named += 1
        self.assertGreater(named, 10)

    def test_every_note_opens_with_what_to_look_at(self):
        for note in NOTES:
            title, empty, *opening = note.read_text("utf-8").splitlines()[:12]
            self.assertTrue(title.startswith("# ") and not empty, note)
            first = opening if note == INDEX else opening[:1]  # the index says first what the notes are
            self.assertTrue(any(line.startswith(("![", "    make ")) for line in first), note)

    def test_commands_are_commands(self):
        # Without the variables of a make around the tests.
        environment = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
        commands = set()
        for page in PAGES:
            for line in page.read_text("utf-8").splitlines():
                if line.startswith("    make "):
                    commands.add(line.split("#")[0].split(";")[0].strip())
        self.assertGreater(len(commands), 20)
        for command in sorted(commands):
            words = shlex.split(command)[1:]
            if any(word.isupper() for word in words) or "..." in command:
                continue  # a pattern
            make = ["make", "-n", "-o", "build/lockstep", *words]
            done = subprocess.run(make, cwd=ROOT, env=environment, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, f"{command}: {done.stderr}")
            for scene in re.findall(r"\bSCENE=(\w+)$", "\n".join(words), re.MULTILINE):
                self.assertTrue(list((ROOT / "scenes").glob(f"*/{scene}.toml")), command)


if __name__ == "__main__":
    unittest.main()

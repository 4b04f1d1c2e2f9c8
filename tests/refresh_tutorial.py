"""Runs every command of docs/tutorial.md in an empty folder and prints the text with what they print now.

python3 refresh_tutorial.py TUTORIAL FOLDER_OF_PROGRAM > new.md; exits with 1 and says which where a command fails. Lines
that begin with four blanks and "$ " are commands; indented lines behind them are replaced.
"""
import os
import subprocess
import sys
import tempfile

LONGEST = 16  # lines of an output; the middle of a longer one is left out


def shown(output):
    lines = output.rstrip("\n").split("\n") if output.strip() else []
    if len(lines) > LONGEST:
        lines = lines[:LONGEST - 3] + ["..."] + lines[-2:]
    return [("    " + line).rstrip() for line in lines]


def is_output(lines, i):
    """Of the command before: indented, or an empty line within."""
    while i < len(lines) and lines[i] == "":
        i += 1
    return i < len(lines) and lines[i].startswith("    ") and not lines[i].startswith("    $ ")


def main():
    tutorial, program = sys.argv[1], sys.argv[2]
    environment = dict(os.environ, PATH=os.path.abspath(program) + os.pathsep + os.environ["PATH"], LC_ALL="C.UTF-8")
    text, failed = [], False
    with open(tutorial, encoding="utf-8") as file:
        lines = file.read().split("\n")
    with tempfile.TemporaryDirectory() as folder:
        i = 0
        while i < len(lines):
            text.append(lines[i])
            i += 1
            if not text[-1].startswith("    $ "):
                continue
            command = text[-1][6:]
            done = subprocess.run(command, shell=True, cwd=folder, env=environment, capture_output=True, text=True)
            if done.returncode != 0:
                print("%s: exit code %d: %s" % (command, done.returncode, done.stderr), file=sys.stderr)
                failed = True
            text += shown(done.stdout)
            while is_output(lines, i):
                i += 1
    sys.stdout.write("\n".join(text))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

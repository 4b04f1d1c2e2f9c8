"""What the commands in the documents print: compared with what the documents show, or written into them.

python3 document_outputs.py [--write] PROGRAM DOCUMENT...

An indented line that begins with "$ " is a command, the indented lines behind it are what it prints on standard output,
and a line "..." among them stands for lines left out. The commands of a document run in order in an empty folder, beside
`data` of the sources. Words must be equal, and numbers to the last but one digit; how lines are broken does not count.
With --write the documents are made to show what is printed now, and what they leave out stays out. Exits with 1 and says
what differs, or which command fails.
"""
import argparse
import difflib
import os
import pathlib
import re
import subprocess
import sys
import tempfile

COMMAND = re.compile(r"( {4,})\$ (.*)")
LEFT_OUT = "..."
# Digits of a name (x^3, k3) are none. In brackets: standard deviation of the last digits.
NUMBER = re.compile(r"(?<![\w.^])([-+]?)(\d+)(?:\.(\d+))?(?:\((\d+)\))?(?:e([-+]?\d+))?(?![\w])")


def close(shown, printed):
    """Within one of the last but one digit; of two digits and fewer, which may be all there is, one of the last."""
    sign, whole, decimals, deviation, exponent = shown
    digits = len((whole + decimals).lstrip("0"))
    last = 10.0 ** (int(exponent or 0) - len(decimals))
    if digits <= 1 and not (decimals or exponent or deviation):
        return shown == printed  # counts
    most = (10.0 if digits > 2 else 1.0) * last

    def value(number):
        return float("%s%s.%se%s" % (number[0], number[1], number[2] or "0", number[4] or "0"))

    return (abs(value(shown) - value(printed)) <= 1.001 * most and bool(deviation) == bool(printed[3])
            and abs(int(deviation or 0) - int(printed[3] or 0)) <= 1)


def agree(shown, printed):
    return (len(shown) == len(printed) and all(
        NUMBER.sub("#", a) == NUMBER.sub("#", b) and all(map(close, NUMBER.findall(a), NUMBER.findall(b)))
        for a, b in zip(shown, printed)))


def pieces_of(lines):
    """Between the lines that stand for others; the first and the last are empty where those are left out."""
    pieces = [[]]
    for line in lines:
        if line == LEFT_OUT:
            pieces.append([])
        else:
            pieces[-1].append(line)
    return pieces


def shows(lines, printed):
    """Whether the lines of a document are what was printed."""
    pieces, words = [" ".join(piece).split() for piece in pieces_of(lines)], " ".join(printed).split()
    if len(pieces) == 1:
        return agree(pieces[0], words)
    first, *inner, last = pieces
    end = len(words) - len(last)
    if not agree(first, words[:len(first)]) or not agree(last, words[end:]):
        return False
    at = len(first)
    for piece in inner:
        while at + len(piece) <= end and not agree(piece, words[at:at + len(piece)]):
            at += 1
        at += len(piece)
    return at <= end


def most_alike(piece, lines, begin):
    """Where that begins which the first line of a piece, but for empty ones, was before its numbers changed."""
    blank = next((k for k, line in enumerate(piece) if line), 0)

    def likeness(i):
        return difflib.SequenceMatcher(None, NUMBER.sub("#", piece[blank]), NUMBER.sub("#", lines[i])).ratio()

    return max(begin, max(range(begin, len(lines)), key=likeness, default=begin) - blank)


def abridged(printed, like):
    """The printed lines without what lines of a document leave out."""
    pieces, result, at = pieces_of(like), [], 0
    for k, piece in enumerate(pieces):
        first = at if k == 0 else most_alike(piece, printed, at) if piece else len(printed)
        if first > at:
            result.append(LEFT_OUT)
        if k + 1 == len(pieces):
            return result + printed[first:]
        if piece:
            at = 1 + most_alike(piece[-1:], printed, first)
            result += printed[first:at]


def end_of_output(lines, i, indent):
    """Of a command before line i: indented lines, and empty ones among them."""
    end = i
    while i < len(lines) and (lines[i] == "" or lines[i].startswith(indent)) and not COMMAND.match(lines[i]):
        i += 1
        if lines[i - 1] != "":
            end = i
    return end


def run_document(path, environment, data):
    """Its text with what is printed now, and what to say of it."""
    lines, text, messages, i = path.read_text(encoding="utf-8").split("\n"), [], [], 0
    with tempfile.TemporaryDirectory() as folder:
        os.symlink(data, os.path.join(folder, "data"))
        while i < len(lines):
            text.append(lines[i])
            i += 1
            typed = COMMAND.match(text[-1])
            if not typed:
                continue
            place, (indent, command) = "%s:%d" % (path.name, i), typed.groups()
            while command.endswith("\\"):
                text.append(lines[i])
                command = command[:-1] + lines[i].lstrip()
                i += 1
            done = subprocess.run(command, shell=True, cwd=folder, env=environment, capture_output=True, text=True)
            if done.returncode != 0:
                messages.append("%s: %s: exit code %d: %s" % (place, command, done.returncode, done.stderr))
            end = end_of_output(lines, i, indent)
            shown = [line[len(indent):].rstrip() for line in lines[i:end]]
            printed = [line.rstrip() for line in done.stdout.rstrip("\n").split("\n")] if done.stdout.strip() else []
            now = abridged(printed, shown)
            if not shows(shown, printed):
                messages.append("\n".join(difflib.unified_diff(
                    shown, now, place + ": shown", command + ": printed", lineterm="")))
            text += [(indent + line).rstrip() for line in now]
            i = end
    return "\n".join(text), messages


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--write", action="store_true")
    arguments.add_argument("program", type=pathlib.Path)
    arguments.add_argument("documents", type=pathlib.Path, nargs="+")
    typed = arguments.parse_args()
    environment = dict(os.environ, LC_ALL="C.UTF-8",
                       PATH=str(typed.program.resolve().parent) + os.pathsep + os.environ["PATH"])
    differ = False
    for document in typed.documents:
        text, messages = run_document(document, environment, pathlib.Path(__file__).resolve().parents[1] / "data")
        for message in messages:
            print(message, file=sys.stderr)
        differ = differ or bool(messages)
        if typed.write:
            document.write_text(text, encoding="utf-8")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())

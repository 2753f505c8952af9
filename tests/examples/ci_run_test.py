#!/usr/bin/env python3
"""examples/ci/run and the shell steps of the pipelines beside it, with a stand-in for sightline and a server
that answers as GitHub and GitLab do.

usage: ci_run_test.py FOLDER_OF_CI
"""

import http.server
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading

CI = pathlib.Path(sys.argv[1])
MARKER = "<!-- sightline map -->"

# Writes the files that it is asked for and remembers its words; gate ends with GATE_STATUS.
SIGHTLINE = """#!/usr/bin/env bash
echo "$*" >> "$CALLS"
previous=
for word in "$@"; do
  case $previous in -o | --json | --junit | --sarif | --markdown) echo "$1" > "$word" ;; esac
  previous=$word
done
case "$1 $*" in *--list-inputs*) echo "$MAP_CONFIG" ;; esac
[ "$1" != diff ] || { echo '## changed'; exit 1; }
[ "$1" != gate ] || exit "${GATE_STATUS:-0}"
"""


class Server(http.server.BaseHTTPRequestHandler):
    comments, status, asked = [], 200, []

    def answer(self):
        length = int(self.headers.get("Content-Length") or 0)
        body = json.loads(self.rfile.read(length)) if length else None
        type(self).asked.append((self.command, self.path.split("?")[0], body))
        page = int(re.search(r"[?&]page=(\d+)", self.path).group(1)) if "page=" in self.path else 1
        listed = type(self).comments[100 * (page - 1):100 * page]
        self.send_response(type(self).status if self.command == "GET" or type(self).status != 200
                           else 201 if self.command == "POST" else 200)
        self.end_headers()
        self.wfile.write(json.dumps(listed if self.command == "GET" else {}).encode())

    do_GET = do_POST = do_PATCH = do_PUT = answer

    def log_message(self, *_):
        pass


def write_program(path, text):
    path.write_text(text)
    path.chmod(0o755)


class Workplace:
    def __init__(self, folder, server):
        self.folder = pathlib.Path(folder)
        (self.folder / "ci").mkdir()
        shutil.copy(CI / "run", self.folder / "ci" / "run")
        (self.folder / "drive.yaml").write_text("mapping: {scans: a}\nevaluation: {scans: b}\n")
        programs = self.folder / "programs"
        programs.mkdir()
        write_program(programs / "sightline", SIGHTLINE)
        for name in ("apt-get", "gh", "sudo"):
            write_program(programs / name, "#!/bin/sh\nexit 0\n")
        self.address = f"http://127.0.0.1:{server.server_port}"
        self.environment = dict(
            os.environ, PATH=f"{programs}:{os.environ['PATH']}", CALLS=str(self.folder / "calls"),
            MAP_OUT="map", MAP_CONFIG="drive.yaml", MAP_CACHE="map-cache", MAP_RELEASE="release/map.slmap",
            GITHUB_OUTPUT=str(self.folder / "output"), GITHUB_STEP_SUMMARY=str(self.folder / "summary"),
            GITHUB_WORKSPACE=str(self.folder), GITHUB_ACTION_PATH=str(self.folder / "ci"),
            RUNNER_TEMP=str(self.folder), HOME=str(self.folder), no_proxy="*")

    def shell(self, text, **more):
        return subprocess.run(["bash", "-eo", "pipefail", "-c", text], cwd=self.folder, capture_output=True,
                              text=True, env=dict(self.environment, **more))

    def calls(self):
        file = self.folder / "calls"
        lines = file.read_text().splitlines() if file.exists() else []
        file.unlink(missing_ok=True)
        return lines


def check_all(place):
    (place.folder / "release").mkdir()
    (place.folder / "release" / "map.slmap").write_text("map")
    for status in (0, 69, 67):
        run = place.shell("ci/run", GATE_STATUS=str(status))
        assert run.returncode == status, (status, run.stderr)
        calls = place.calls()
        verbs = [call.split()[0] for call in calls]
        if status == 67:
            assert verbs[-1] == "gate", "a gate that cannot judge ends the run"
            continue
        assert verbs.index("gate") < verbs.index("report")
        report = calls[verbs.index("report")]
        assert "--gate map/gate.json" in report and "--against release/map.slmap" in report
        comment = (place.folder / "map" / "comment.md").read_text()
        assert comment.startswith(MARKER + "\n") and "## changed" in comment


def check_post(place):
    github = dict(PR_NUMBER="7", GITHUB_REPOSITORY="a/b", GH_TOKEN="t", GITHUB_API_URL=place.address)
    gitlab = dict(CI_MERGE_REQUEST_IID="7", CI_PROJECT_ID="5", MAP_TOKEN="t", CI_API_V4_URL=place.address)
    others = [{"id": i, "body": "words"} for i in range(100)]
    ours = {"id": 333, "body": MARKER + "\nold"}
    of_github = "/repos/a/b/issues"
    of_gitlab = "/projects/5/merge_requests/7/notes"
    for name, environment, comments, expected in (
            ("made", github, others[:3], ("POST", f"{of_github}/7/comments")),
            ("edited on the second page", github, others + [ours], ("PATCH", f"{of_github}/comments/333")),
            ("made", gitlab, [], ("POST", of_gitlab)), ("edited", gitlab, [ours], ("PUT", f"{of_gitlab}/333"))):
        Server.comments, Server.status, Server.asked = comments, 200, []
        run = place.shell("ci/run post", **environment)
        assert run.returncode == 0, run.stderr
        assert Server.asked[-1][:2] == expected, (name, Server.asked)
        assert Server.asked[-1][2]["body"].startswith(MARKER)
    for status, expected in ((403, 0), (404, 0), (401, 0), (500, 1)):
        Server.status, Server.asked = status, []
        run = place.shell("ci/run post", **github)
        assert run.returncode == expected, (status, run.stderr)
        assert expected or "no right to comment" in run.stderr
    assert place.shell("ci/run post").returncode == 0, "no pull request"
    assert place.shell("ci/run dance").returncode == 64


def blocks_of_run(file):
    """Shell text of each `run:` of a workflow or action, expressions filled in."""
    values = {"vars.SIGHTLINE_DEB": "file://$PWD/package.deb", "vars.SIGHTLINE_SHA256": "$SUM"}
    fill = lambda text: re.sub(r"\$\{\{ *(.*?) *\}\}", lambda m: values.get(m.group(1), "1"), text)
    lines = (CI / file).read_text().splitlines()
    for i, line in enumerate(lines):
        found = re.match(r"( *)run: (.*)", line)
        if not found:
            continue
        if found.group(2) not in ("|", ">-"):
            yield fill(found.group(2))
            continue
        inner = []
        for other in lines[i + 1:]:
            if other.strip() and len(other) - len(other.lstrip()) <= len(found.group(1)):
                break
            inner.append(other.strip())
        yield fill((" " if found.group(2) == ">-" else "\n").join(inner))


def check_steps(place):
    (place.folder / "package.deb").write_text("package")
    total = subprocess.run(["sha256sum", place.folder / "package.deb"], capture_output=True, text=True, check=True)
    known = dict(SUM=total.stdout.split()[0], PACKAGE=f"file://{place.folder}/package.deb")
    known["SHA256"] = known["SUM"]
    for file, least in (("github.yml", 10), ("action.yml", 4)):
        blocks = list(blocks_of_run(file))
        assert len(blocks) >= least, file
        for block in blocks:
            run = place.shell(block, **known)
            assert run.returncode == 0, (file, block, run.stderr)
    run = place.shell(list(blocks_of_run("action.yml"))[1], **dict(known, SHA256="0" * 64))
    assert run.returncode != 0, "a package with another checksum is refused"
    judge = list(blocks_of_run("action.yml"))[-1]
    place.calls()
    run = place.shell(judge, GATE_STATUS="69")
    assert run.returncode == 69 and any(call.startswith("report") for call in place.calls()), run.stderr
    for file in ("gitlab.yml", "gitlab-component.yml"):
        for line in re.findall(r"^ +- ((?:ci/run|\$\[\[ inputs.script \]\]) .*)$", (CI / file).read_text(), re.M):
            run = place.shell(line.replace("$[[ inputs.script ]]", "ci/run"))
            assert run.returncode == 0, (file, line, run.stderr)


def main():
    for program in ("jq", "curl"):
        if not shutil.which(program):
            print(f"there is no {program}")
            sys.exit(77)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Server)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    for check in (check_all, check_post, check_steps):
        with tempfile.TemporaryDirectory() as folder:
            check(Workplace(folder, server))
            print(f"{check.__name__} holds")


main()

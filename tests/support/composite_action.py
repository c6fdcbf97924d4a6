"""A composite GitHub Action, run as GitHub runs it: `run` steps in bash, actions of others by stand-ins of a test."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

_EXPRESSION = re.compile(r"\$\{\{ (.+?) \}\}")
_COMPARISON = re.compile(r"(\S+) ([!=])= '(.*)'")

Outputs = dict[str, str]
StandIn = Callable[[Mapping[str, str]], Outputs]
"""From what a step passes `with` to its outputs."""


@dataclass
class Run:
    """One run of an action.

    Attributes:
        path: the action.yml.
        workspace: the folder that the job's steps begin in.
        temp: the runner's folder for what a job leaves behind.
        inputs: what the workflow passes; the rest has its defaults.
        stand_ins: for actions, by name without version.
        said: what the shell steps printed on both streams.
    """

    path: Path
    workspace: Path
    temp: Path
    inputs: Mapping[str, str]
    stand_ins: Mapping[str, StandIn]
    said: str = ""
    _steps: dict[str, Outputs] = field(default_factory=dict)

    def outputs(self) -> Outputs:
        """Run all steps and return the action's outputs; a step that fails raises `CalledProcessError`."""
        action = yaml.safe_load(self.path.read_text(encoding="utf-8"))
        for name in self.inputs:
            assert name in action["inputs"], f"no input {name}"
        defaults = {name: str(one.get("default", "")) for name, one in action["inputs"].items()}
        self.inputs = {**defaults, **self.inputs}
        for step in action["runs"]["steps"]:
            if "if" in step and self._value(step["if"]) != "true":
                continue
            found = self._run(step) if "run" in step else self._use(step)
            if "id" in step:
                self._steps[step["id"]] = found
        return {name: self._filled(one["value"]) for name, one in action["outputs"].items()}

    def _run(self, step: Mapping[str, Any]) -> Outputs:
        assert step["shell"] == "bash"
        script, output = self.temp / "step.sh", self.temp / "output"
        script.write_text(step["run"])
        output.write_text("")
        env = {name: self._filled(text) for name, text in step.get("env", {}).items()}
        runner = {"GITHUB_OUTPUT": output, "GITHUB_ACTION_PATH": self.path.parent, "RUNNER_TEMP": self.temp}
        done = subprocess.run(
            ["bash", "--noprofile", "--norc", "-eo", "pipefail", script],
            cwd=self.workspace,
            env={**os.environ, **{name: str(value) for name, value in runner.items()}, **env},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        self.said += done.stdout
        done.check_returncode()
        return dict(line.split("=", 1) for line in output.read_text().splitlines())

    def _use(self, step: Mapping[str, Any]) -> Outputs:
        name, _, version = step["uses"].partition("@")
        assert re.fullmatch(r"v\d+", version), step["uses"]
        return self.stand_ins[name]({key: self._filled(str(value)) for key, value in step.get("with", {}).items()})

    def _filled(self, text: str) -> str:
        return _EXPRESSION.sub(lambda found: self._value(found[1]), text)

    def _value(self, expression: str) -> str:
        if compared := _COMPARISON.fullmatch(expression):
            return str((self._value(compared[1]) == compared[3]) == (compared[2] == "=")).lower()
        kind, *names = expression.split(".")
        if kind == "inputs":
            return self.inputs[names[0]]
        if kind == "runner":
            return {"os": "Linux", "arch": "X64"}[names[0]]
        assert kind == "steps" and names[1] == "outputs", expression
        # GitHub gives the empty string for an output that a step has not set.
        return self._steps[names[0]].get(names[2], "")

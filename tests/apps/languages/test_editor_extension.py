"""Extension for VS Code: what it says of the languages and of a launch is what the servers know, and it starts them."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from virtualrobot_apps.languages.editor.command import editor
from virtualrobot_apps.languages.editor.launch import KNOWN, OF_SCRIPTS
from virtualrobot_apps.languages.editor.lsp import LANGUAGES
from virtualrobot_apps.languages.rapid.lexer import KEYWORDS as RAPID
from virtualrobot_apps.languages.urscript.lexer import KEYWORDS as URSCRIPT

FOLDER = Path(__file__).resolve().parents[3] / "clients" / "vscode"
NODE = shutil.which("node")
PACKAGE = json.loads((FOLDER / "package.json").read_text())

HOST = """
const made = { started: 0, types: [] };
const vscode = {
  workspace: {
    getConfiguration: (name) => ({ get: (key) => `${name}.${key}` }),
    createFileSystemWatcher: (pattern) => ({ pattern }),
  },
  debug: {
    registerDebugAdapterDescriptorFactory: (type, factory) => {
      made.types.push(type);
      return Object.assign(made, { factory });
    },
  },
  DebugAdapterExecutable: class { constructor(command, args) { Object.assign(this, { command, args }); } },
};
class LanguageClient {
  constructor(id, name, server, client) { Object.assign(made, { server, client }); }
  async start() { made.started += 1; }
  async stop() { made.started -= 1; }
}
const Module = require("node:module");
const load = Module._load;
Module._load = (name, ...rest) =>
  name === "vscode" ? vscode : name === "vscode-languageclient/node" ? { LanguageClient } : load(name, ...rest);
const extension = require(process.argv[1]);
const context = { subscriptions: [] };
extension.activate(context).then(async () => {
  const adapter = made.factory.createDebugAdapterDescriptor();
  const started = made.started;
  await extension.deactivate();
  console.log(JSON.stringify({ ...made, adapter, startedAfter: started, kept: context.subscriptions.length }));
});
"""
"""Stand-in for what VS Code gives an extension, as far as this one asks for it."""


def grammar(language: str) -> dict[str, Any]:
    """Return the grammar of a language."""
    (path,) = (one["path"] for one in PACKAGE["contributes"]["grammars"] if one["language"] == language)
    return json.loads((FOLDER / path).read_text())


def first_scope(language: str, text: str) -> str:
    """Return the scope that the first rule which matches at the begin of a text gives it."""
    for one in grammar(language)["patterns"]:
        found = re.match(one.get("match", one.get("begin")), text)
        if found is not None:
            return one.get("name") or one["captures"]["1"]["name"]
    return ""


def test_the_languages_are_those_that_are_served() -> None:
    told = {one["id"]: tuple(one["extensions"]) for one in PACKAGE["contributes"]["languages"]}
    assert told == {one.name: one.endings for one in LANGUAGES}


@pytest.mark.parametrize(("language", "names"), [("rapid", KNOWN), ("urscript", OF_SCRIPTS)])
def test_a_launch_has_the_names_and_types_that_the_adapter_knows(language: str, names: dict[str, Any]) -> None:
    types = {str: "string", list: "array", bool: "boolean"}
    (debugger,) = [one for one in PACKAGE["contributes"]["debuggers"] if one["type"] == language]
    told = {}
    for name, one in debugger["configurationAttributes"]["launch"]["properties"].items():
        told[name] = one["type"] if isinstance(one["type"], list) else [one["type"]]
    known = {}
    for name, kinds in names.items():
        known[name] = [types[one] for one in (kinds if isinstance(kinds, tuple) else (kinds,))]
    assert told == known


@pytest.mark.parametrize(("language", "words"), [("rapid", sorted(RAPID)), ("urscript", sorted(URSCRIPT))])
def test_reserved_words_have_a_color(language: str, words: list[str]) -> None:
    scopes = {word: first_scope(language, word) for word in words}
    assert {
        word: one for word, one in scopes.items() if not one.startswith(("keyword.", "storage.", "constant."))
    } == {}
    assert not first_scope(language, "endless;").startswith("keyword.")


@pytest.mark.parametrize(
    ("language", "text", "scope"),
    [
        ("rapid", "! IF it is", "comment.line.exclamation.rapid"),
        ("rapid", '"a ""b"" c"', "string.quoted.double.rapid"),
        ("rapid", "Proc main()", "storage.type.rapid"),
        ("rapid", "0xFF", "constant.numeric.rapid"),
        ("rapid", r"\Num:=1", "variable.parameter.rapid"),
        ("rapid", "MoveL home, v100", "entity.name.function.call.rapid"),
        ("urscript", "# if it is", "comment.line.number-sign.urscript"),
        ("urscript", "p[0, 0, 0, 0, 0, 0]", "support.type.urscript"),
        ("urscript", "movel(home)", "entity.name.function.call.urscript"),
        ("urscript", "1.5e-3", "constant.numeric.urscript"),
    ],
)
def test_words_have_the_colors_of_what_they_are(language: str, text: str, scope: str) -> None:
    assert first_scope(language, text) == scope


def test_files_that_the_package_names_are_there() -> None:
    named = [PACKAGE["main"], *(one["path"] for one in PACKAGE["contributes"]["grammars"])]
    named += [one["configuration"] for one in PACKAGE["contributes"]["languages"]]
    assert [one for one in named if not (FOLDER / one).is_file()] == []
    for one in FOLDER.glob("**/*.json"):
        if "node_modules" not in one.parts:
            json.loads(one.read_text())


@pytest.mark.skipif(NODE is None, reason="no Node.js: install it to run the extension")
def test_it_starts_the_language_server_and_debug_adapters() -> None:
    done = subprocess.run([str(NODE), "-e", HOST, str(FOLDER / "extension.js")], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    made = json.loads(done.stdout)
    assert made["server"] == {"command": "virtualrobot.command", "args": ["editor", "lsp"]}
    assert made["adapter"] == {"command": "virtualrobot.command", "args": ["editor", "dap"]}
    assert [one["language"] for one in made["client"]["documentSelector"]] == [one.name for one in LANGUAGES]
    (pattern,) = (one["pattern"] for one in [made["client"]["synchronize"]["fileEvents"]])
    beside = [ending.removeprefix(".") for one in LANGUAGES if one.beside for ending in one.endings]
    assert pattern == f"**/*.{{{','.join(beside)}}}"
    assert made["types"] == [one["type"] for one in PACKAGE["contributes"]["debuggers"]] == ["rapid", "urscript"]
    assert (made["startedAfter"], made["started"], made["kept"]) == (1, 0, 3)
    assert sorted(editor.commands) == ["dap", "lsp"]

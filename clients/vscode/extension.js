// Extension for VS Code: starts `virtualrobot editor lsp` for texts in RAPID and URScript, and `virtualrobot editor dap`
// for each program that is debugged.

const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

function command() {
  return vscode.workspace.getConfiguration("virtualrobot").get("command");
}

async function activate(context) {
  const files = vscode.workspace.createFileSystemWatcher("**/*.{mod,modx,sys,sysx,prg}");
  const adapters = {
    createDebugAdapterDescriptor: () => new vscode.DebugAdapterExecutable(command(), ["editor", "dap"]),
  };
  context.subscriptions.push(
    files,
    ...["rapid", "urscript"].map((type) => vscode.debug.registerDebugAdapterDescriptorFactory(type, adapters)),
  );
  client = new LanguageClient(
    "virtualrobot",
    "VirtualRobot",
    { command: command(), args: ["editor", "lsp"] },
    { documentSelector: [{ language: "rapid" }, { language: "urscript" }], synchronize: { fileEvents: files } },
  );
  await client.start();
}

function deactivate() {
  return client?.stop();
}

module.exports = { activate, deactivate };

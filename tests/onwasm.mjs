// Runs one board_*.py on MicroPython's WebAssembly build, which makes no machine code: the native and
// viper decorators are dropped, so the plain form of each function runs, with 31-bit small integers.
//
// node tests/onwasm.mjs MICROPYTHON.MJS FILE ROOT...    FILE below one of the ROOTs

import { readFileSync, readdirSync, statSync } from "node:fs";
import { join, relative } from "node:path";
import { pathToFileURL } from "node:url";

const HEAP_BYTES = 4 * 1024 * 1024;
const LIB = "/lib";
const NO_SUCH_FILE = 44; // as its file system numbers errors; 2 on the board
const DECORATOR = /^[ \t]*@micropython\.(?:native|viper)\n/gm;

// Its assertions ask the table, which never changes, at every call that may raise: half of the time.
const get = WebAssembly.Table.prototype.get;
const known = [];
WebAssembly.Table.prototype.get = function (index) {
  return (known[index] ??= get.call(this, index));
};

const [module, file, ...roots] = process.argv.slice(2);
const { loadMicroPython } = await import(pathToFileURL(module));
const print = (line) => console.log(line);
const options = { heapsize: HEAP_BYTES, linebuffer: true, stdout: print, stderr: print };
const micropython = await loadMicroPython(options);

function put(root, folder) {
  for (const name of readdirSync(folder)) {
    const path = join(folder, name);
    if (statSync(path).isDirectory()) put(root, path);
    else if (name.endsWith(".py")) {
      const parts = [LIB, ...relative(root, path).split("/")];
      for (let n = 1; n < parts.length; n++) {
        const parent = parts.slice(0, n).join("/");
        if (!micropython.FS.analyzePath(parent).exists) micropython.FS.mkdir(parent);
      }
      const text = readFileSync(path, "utf8").replace(DECORATOR, "");
      micropython.FS.writeFile(parts.join("/"), text);
    }
  }
}

for (const root of roots) put(root, root);
try {
  micropython.runPython(`
import sys
sys.path[:] = ["${LIB}"]
import builtins
_open = open
def open_as_the_board(*arguments):
    try:
        return _open(*arguments)
    except OSError as error:
        raise OSError(2 if error.args[0] == ${NO_SUCH_FILE} else error.args[0])
builtins.open = open_as_the_board
import boardtest
boardtest.main("${LIB}/${file}")
`);
} catch (error) {
  console.log(error.message);
  process.exit(1);
}

// A button of the driver's page that is created on demand.

import { byId } from "./dom.js";

/** Like the others: the mark of the target `like` with its ring, a label, a small line. */
export function button(id, like, kind) {
  const tile = document.createElement("button");
  [tile.type, tile.id, tile.className] = ["button", id, `target ${kind}`];
  const mark = byId(like).querySelector(".mark").cloneNode(true);
  for (const name of ["label", "small"]) {
    const line = document.createElement("span");
    [line.className, line.dir] = [name, "auto"];
    tile.append(line);
  }
  tile.prepend(mark);
  byId("stop").before(tile);
  return tile;
}

/** Loads a style sheet; throws when it does not load. */
export function styled(path) {
  return new Promise((resolve, reject) => {
    const link = document.createElement("link");
    [link.rel, link.href, link.onload] = ["stylesheet", path, resolve];
    link.onerror = () => reject(new Error(`${path} does not come`));
    document.head.append(link);
  });
}

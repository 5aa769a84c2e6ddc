// Parts of the driver's page that show optional data from the host.

import { fetchPart } from "./wanted.js";

/** Optional data, and the parts that show it from then on. */
const PARTS = { where: "small_map", assist: "assist_sign" };
const coming = {};
const parts = {};

/** `news`: the host's state. */
export function show(news, strings) {
  for (const [name, file] of Object.entries(PARTS)) {
    const value = news[name];
    if (value) coming[name] ??= fetchPart(file, (part) => (parts[name] = part));
    parts[name]?.show(value, strings, news);
  }
}

// The page's elements and facts by name; writes only what differs.

const body = document.body;
export const byId = (id) => document.getElementById(id);
export const setText = (id, text) => {
  const element = byId(id);
  if (element.textContent !== text) element.textContent = text;
};
/** A new element of a drawing (SVG), with these attributes. */
export const svg = (name, attributes = {}) => {
  const made = document.createElementNS(document.querySelector("svg").namespaceURI, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
};
/** A fact that the style sheets use. */
export const setData = (name, value) => {
  if (body.dataset[name] !== String(value)) body.dataset[name] = value;
};

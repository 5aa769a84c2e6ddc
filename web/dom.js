// The page's elements and facts by name; writes only what differs.

const body = document.body;
export const byId = (id) => document.getElementById(id);
export const setText = (id, text) => {
  const element = byId(id);
  if (element.textContent !== text) element.textContent = text;
};
/** A fact that the style sheets use. */
export const setData = (name, value) => {
  if (body.dataset[name] !== String(value)) body.dataset[name] = value;
};

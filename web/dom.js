// The page's elements and facts by name; changes only what differs.

const body = document.body;
export const byId = (id) => document.getElementById(id);
export const setText = (id, text) => {
  const element = byId(id);
  if (element.textContent !== text) element.textContent = text;
};
/** A fact the style sheets go by. */
export const setData = (name, value) => {
  if (body.dataset[name] !== String(value)) body.dataset[name] = value;
};

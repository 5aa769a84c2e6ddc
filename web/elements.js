// New elements of the caretaker's page; text is written again only if it differs.

/** Names and sentences of people may run from right to left. */
export const element = (name, className = "", text = "") => {
  const made = document.createElement(name);
  [made.className, made.textContent, made.dir] = [className, text, "auto"];
  return made;
};

export const button = (text, act, className = "") => {
  const made = element("button", className, text);
  made.type = "button";
  made.addEventListener("click", act);
  return made;
};

export const put = (made, text) => {
  if (made.textContent !== text) made.textContent = text;
};

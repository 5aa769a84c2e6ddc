// A request of the caretaker's page that posts JSON to the host, for fetch.

export const post = (content) => ({
  method: "POST",
  headers: { "Content-Type": "application/json" },
  body: JSON.stringify(content),
});

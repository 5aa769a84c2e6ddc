// The texts of a part of the pages, loaded when that part is needed.

const HOME = "nl";

/** strings/LANGUAGE-PART.json, else the Dutch one. Throws when the host does not answer. */
export async function tableOf(language, part) {
  for (const name of [language, HOME]) {
    const answer = await fetch(`/strings/${name}-${part}.json`);
    if (answer.ok) return answer.json();
    if (answer.status !== 404) throw new Error(`the host answered ${answer.status}`);
  }
  throw new Error(`no texts of ${part}`);
}

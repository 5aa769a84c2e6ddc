// The pause before a page asks the host again for what has not come.

const RETRY_MS = 2000;

export const retryPause = () => new Promise((resume) => setTimeout(resume, RETRY_MS));

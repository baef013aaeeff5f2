// The service, as one user sees it. Refusals are errors whose message is the service's own sentence.
const ROOT = '/api/v1';
const KEPT = 'lumenray-token';

export class Api {
  constructor(token) {
    this.headers = { Authorization: `Bearer ${token}` };
  }

  // Of this tab alone: who closes it is signed out.
  static kept() {
    const token = sessionStorage.getItem(KEPT);
    return token === null ? null : new Api(token);
  }

  static keep(token) {
    sessionStorage.setItem(KEPT, token);
    return new Api(token);
  }

  static forget() {
    sessionStorage.removeItem(KEPT);
  }

  async ask(method, path, body, headers = {}) {
    const answer = await fetch(ROOT + path, { method, body, headers: { ...this.headers, ...headers } });
    if (!answer.ok) throw await refusal(answer);
    return answer;
  }

  async get(path) {
    return (await this.ask('GET', path)).json();
  }

  async send(method, path, value, headers) {
    const answer = await this.ask(method, path, value === undefined ? undefined : JSON.stringify(value), headers);
    return answer.status === 204 ? null : answer.json();
  }

  async bytes(path) {
    return (await this.ask('GET', path)).arrayBuffer();
  }

  file(job, name) {
    return this.bytes(`/jobs/${job}/files/${name.split('/').map(encodeURIComponent).join('/')}`);
  }

  // A request of its own kind, for fetch does not tell how much of a body is sent.
  upload(path, file, told) {
    return new Promise((resolve, reject) => {
      const request = new XMLHttpRequest();
      request.open('POST', ROOT + path);
      request.setRequestHeader('Authorization', this.headers.Authorization);
      request.upload.onprogress = (event) => told(event.loaded / event.total);
      request.onerror = () => reject(new Error('the service cannot be reached'));
      request.onload = () => {
        if (request.status < 300) resolve(JSON.parse(request.responseText));
        else reject(new Error(sentence(request.responseText, request.status)));
      };
      request.send(file);
    });
  }

  // Calls told(job) with every change until the job has ended; EventSource could not send the token.
  async follow(job, told, signal) {
    const answer = await fetch(`${ROOT}/jobs/${job}/events`, { headers: this.headers, signal });
    if (!answer.ok) throw await refusal(answer);
    const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
    for (let rest = ''; ;) {
      const { done, value } = await reader.read();
      if (done) return;
      const events = (rest + value).split('\n\n');
      rest = events.pop();
      for (const event of events) {
        const data = event.split('\n').find((line) => line.startsWith('data: '));
        if (data) told(JSON.parse(data.slice(6)));
      }
    }
  }
}

async function refusal(answer) {
  const error = new Error(sentence(await answer.text(), answer.status));
  error.status = answer.status;
  return error;
}

function sentence(text, status) {
  try {
    return JSON.parse(text).error;
  } catch {
    return `the service answers ${status}`;
  }
}

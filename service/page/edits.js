// Changes of one scene, which the service keeps; one is sent after the other, so that none is lost by another that overtakes it.
import { say } from './elements.js';

export class Edits {
  constructor(api, scene) {
    this.api = api;
    this.path = `/scenes/${scene.id}/edits`;
    this.kept = { lights: {}, hidden: [], materials: {}, ...scene.edits };
    this.last = Promise.resolve();
  }

  // What is changed of a light.
  light(name) {
    return this.kept.lights[name] ?? {};
  }

  // Calls alter(wanted) with a copy of what is kept; what the service refuses stays as it was.
  change(alter) {
    const sent = this.last.then(async () => {
      const wanted = structuredClone(this.kept);
      alter(wanted);
      const { edits } = await this.api.send('PUT', this.path, wanted);
      this.kept = { lights: {}, hidden: [], materials: {}, ...edits };
      say('changes are kept; they hold for jobs that are ordered from now on');
    });
    this.last = sent.catch(() => {});
    return sent;
  }

  // A value of null takes a change back.
  changeLight(name, changes) {
    return this.change((wanted) => {
      const light = (wanted.lights[name] ??= {});
      for (const [key, value] of Object.entries(changes)) {
        if (value === null) delete light[key];
        else light[key] = value;
      }
    });
  }
}

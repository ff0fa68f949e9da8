// Lets the search work in pages that are opened from a disk, for which browsers start no worker: its script runs in a frame.
// The plugin "offline" of the theme would load such a script from another host, unless one has the name of this file.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(address) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.append(frame);
      const scope = this.scope = frame.contentWindow;
      scope.document.write("<body></body>");
      scope.document.close();
      scope.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
      const script = scope.document.createElement("script");
      script.src = address;
      this.loaded = new Promise((resolve) => (script.onload = resolve));
      scope.document.body.append(script);
    }

    async postMessage(data) {
      await this.loaded;
      this.scope.dispatchEvent(new MessageEvent("message", { data: structuredClone(data) }));
    }
  };
}

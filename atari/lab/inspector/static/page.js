// The page of `atari lab`: an inspector on a WebSocket to the server that served it.

import { h } from "./dom.js";
import { mount } from "./inspector.js";

const root = document.getElementById("inspector");

function connect(take) {
  const address = new URL("ws", location.href);
  address.protocol = "ws:";
  if (take) address.search = "take=1";
  const socket = new WebSocket(address);
  socket.binaryType = "arraybuffer";
  let inspector = null;
  let refused = false;
  const link = {
    send: (message) => socket.readyState === WebSocket.OPEN && socket.send(JSON.stringify(message)),
    // Downloads are links, so that the browser stores the file and shows its progress.
    exportUrl: (name, query) => new URL(`export/${name}${query ? `?${query}` : ""}`, location.href).href,
  };
  socket.onmessage = ({ data }) => {
    if (data instanceof ArrayBuffer) return inspector?.frame(data);
    const message = JSON.parse(data);
    if (message.hello) {
      document.title = `${message.hello.title} · atari lab`;
      inspector?.close();
      inspector = mount(root, link, message.hello, { keys: document });
    } else if (message.refused) {
      refused = true;
      inspector?.close();
      curtain(message.refused, "Use it here", () => connect(true));
    } else {
      inspector?.message(message);
    }
  };
  socket.onclose = ({ reason }) => {
    if (refused) return;
    inspector?.close();
    curtain(reason ? `The connection was closed: ${reason}.` : "The emulator has ended, or the connection was lost. Start `atari lab` again, or", "Connect again", () => connect(false));
  };
}

function curtain(text, action, run) {
  const choice = h("button", { class: "primary", onclick: run }, action);
  root.replaceChildren(h("div", { class: "curtain", role: "alert" }, h("p", {}, text), choice));
  choice.focus();
}

connect(false);

// The inspector in a notebook, for anywidget.

import { h } from "./dom.js";
import { mount } from "./inspector.js";

function render({ model, el }) {
  const root = h("div", { class: "atari-lab", tabIndex: 0 });
  const style = h("style");
  el.append(style, root);
  let inspector = null;
  const link = { send: (message) => model.send(message) };
  const receive = (message, buffers) => {
    if (message.hello) {
      style.textContent = `#${message.picture} { display: none; }`; // the picture above, for pages without a kernel
      inspector?.close();
      inspector = mount(root, link, message.hello, { keys: root });
    } else if (message.frame) {
      const { buffer, byteOffset, byteLength } = buffers[0];
      inspector?.frame(buffer.slice(byteOffset, byteOffset + byteLength));
    } else inspector?.message(message);
  };
  // The notebook has shortcuts of its own for these keys.
  root.addEventListener("keydown", (event) => event.stopPropagation());
  model.on("msg:custom", receive);
  model.send({ do: "open" });
  return () => {
    model.off("msg:custom", receive);
    inspector?.close();
    model.send({ do: "pause" });
  };
}

export default { render };

// The pages of the games: sound on a click; filters of the index, kept in the address. Without it, all games are shown.
for (const figure of document.querySelectorAll("figure.play")) {
  const video = figure.querySelector("video"), button = figure.querySelector("button.sound");
  video.controls = false;
  button.hidden = false;
  button.addEventListener("click", () => {
    video.muted = !video.muted;
    if (video.paused) video.play();
    button.textContent = video.muted ? "Sound on" : "Sound off";
  });
  video.addEventListener("click", () => (video.paused ? video.play() : video.pause()));
}

const form = document.querySelector("form.game-filters");
if (form) {
  const games = [...document.querySelectorAll("ul.games > li")];
  const fits = (game, name, value) => {
    if (name === "name") return game.dataset.name.includes(value.trim().toLowerCase());
    const [low, high] = value.split("-").map(Number);
    return low <= game.dataset[name] && game.dataset[name] <= high;
  };
  const filter = () => {
    const chosen = [...new FormData(form)].filter(([, value]) => value);
    for (const game of games) game.hidden = !chosen.every(([name, value]) => fits(game, name, value));
    form.querySelector("output").textContent = `${games.filter((game) => !game.hidden).length} games`;
    const address = new URLSearchParams(chosen).toString();
    history.replaceState(null, "", address ? `?${address}` : location.pathname);
  };
  for (const [name, value] of new URLSearchParams(location.search)) if (form.elements[name]) form.elements[name].value = value;
  form.hidden = false;
  form.addEventListener("input", filter);
  form.addEventListener("submit", (event) => event.preventDefault());
  filter();
}

// A game in play: a session of the core, or a replay that shows its own, and a fork that plays the same actions beside it.

import { Changes } from "./changes.js";

const randomSeed = () => crypto.getRandomValues(new Uint32Array(1))[0];

// The options that replays and snapshots have as facts.
const OPTIONS = ["repeat_action_probability", "mode", "difficulty", "max_num_frames_per_episode", "interventions"];

/** The settings of a new game: its players, and the options of its sessions. */
export function settingsOf(entry, players, { mode = null, difficulty = null } = {}) {
  if (players > 1 && !entry.two_players) throw new Error(`${entry.title} has no game of two players.`);
  const chosen = players > 1 ? mode ?? entry.two_players.default_mode : mode;
  return { players, options: { repeat_action_probability: 0, mode: chosen, difficulty } };
}

/** The settings of a replay. */
function settingsOfReplay({ players = 1, options = {} }) {
  const known = OPTIONS.filter((name) => name in options).map((name) => [name, options[name]]);
  return { players, options: Object.fromEntries(known) };
}

function opened(play, open) {
  try {
    open(play);
    return play;
  } catch (error) {
    play.close();
    throw error;
  }
}

export class Play {
  isFilm = false;
  acted = false; // whether the reader has played
  #game;
  #player = null;
  #replay = null;

  constructor(core, entry, rom, settings) {
    const { players } = settings;
    if (players > 1 && !entry.two_players) throw new Error(`${entry.title} has no game of two players.`);
    Object.assign(this, { entry, settings, fork: null, changes: new Changes(this) });
    this.#game = core.game(players > 1 ? entry.two_players.core : entry.core, rom);
  }

  /** A new game, or one that goes on from a snapshot. It is recorded. */
  static begin(core, entry, rom, settings, snapshot = null) {
    return opened(new Play(core, entry, rom, settings), (play) => {
      play.session = play.#open();
      if (snapshot) play.session.restore(snapshot);
      play.session.record(entry.release);
      if (!snapshot) play.session.reset();
    });
  }

  /** A replay, from its first frame. */
  static watch(core, entry, rom, replay) {
    return opened(new Play(core, entry, rom, settingsOfReplay(replay.header)), (play) => {
      play.#replay = replay;
      play.#player = play.#game.playReplay(replay);
      play.session = play.#player.session;
      play.checked = 0;
    });
  }

  #open() { return this.#game.play({ seed: randomSeed(), ...this.settings.options }); }

  get players() { return this.settings.players; }
  get rate() { return this.entry.frame_rate; }
  get isReplay() { return this.#player !== null; }
  /** Whether the reader would lose something with this game. */
  get isPlayed() { return !this.isReplay && (this.acted || this.changes.canUndo); }
  get frames() { return this.#replay.frames; }
  get frame() { return this.#player.frame; }
  get difference() { return this.#player.difference; }
  get labels() { return this.session.labels(this.entry.labels.length); }
  get objects() { return this.session.objects(this.entry.objects.length); }

  /** Plays a frame; false after the end. */
  advance([first, second]) {
    if (this.#player) return this.#advanceReplay();
    this.acted ||= first !== 0 || second !== 0;
    this.session.remember();
    if (!this.session.act(first, second)) {
      this.session.goBack();
      return false;
    }
    this.fork?.remember();
    this.fork?.act(first, second);
    this.changes.frame += 1;
    return true;
  }

  #advanceReplay() {
    const outcome = this.#player.advance();
    this.checked = Math.max(this.checked, this.frame);
    return outcome !== "end";
  }

  /** Takes the last frame back; false if there is no older one. */
  goBack() {
    if (this.#player) {
      return this.frame > 0 && this.#player.seek(this.frame - 1, 1_000_000);
    }
    this.fork?.goBack();
    if (!this.session.goBack()) return false;
    this.changes.goBack();
    return true;
  }

  /** Goes to a frame of the replay; false if it needs another call to be there. */
  seek(frame) {
    const there = this.#player.seek(frame);
    this.checked = Math.max(this.checked, this.frame);
    return there;
  }

  /** Leaves the replay at a frame: what is played from there is recorded after it. */
  async goOn(frame, pause) {
    const recorded = this.#player.recorded(this.entry.release, frame);
    while (!recorded.seek(frame)) await pause();
    this.#closeReplay();
    this.session = recorded.takeSession();
  }

  /** Begins a new game of the same settings, after this one in the recording. */
  newGame() {
    this.dropFork();
    this.session.reset();
  }

  /** The screen; with `ahead`, that of some frames later if the actions are held. */
  screen(ahead = 0, [first, second] = [0, 0]) {
    return ahead && !this.#player ? this.session.screenAhead(ahead, first, second) : this.session.screen();
  }

  /** The present state goes on beside this game, with the same actions, and without later changes of RAM. */
  makeFork() {
    this.dropFork();
    const fork = this.#open();
    try {
      fork.restore(this.session.snapshot());
    } catch (error) {
      fork.close();
      throw error;
    }
    this.fork = fork;
  }

  dropFork() {
    this.fork?.close();
    this.fork = null;
  }

  #closeReplay() {
    this.#player?.close();
    this.#replay?.close();
    this.#player = this.#replay = null;
  }

  close() {
    this.dropFork();
    if (this.#player) this.#closeReplay();
    else this.session?.close();
    this.#game.close();
  }
}

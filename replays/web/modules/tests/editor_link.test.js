// Messages go one at a time and in order; of drags that wait the newest goes, and before the end.

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

let sockets;

class FakeSocket {
  static OPEN = 1;
  constructor(address) {
    Object.assign(this, { address, readyState: 0, sent: [] });
    sockets.push(this);
  }
  send(text) {
    this.sent.push(JSON.parse(text));
  }
  open() {
    this.readyState = FakeSocket.OPEN;
    this.onopen();
  }
  hear(message) {
    this.onmessage({ data: JSON.stringify(message) });
  }
  answer() {
    this.hear({ n: this.sent.at(-1).n, ok: true });
  }
}

globalThis.WebSocket = FakeSocket;
const { Link } = await import("studio/editor_link.js");
const heard = [];
const told = { news: (message) => heard.push(message), line: () => {} };

beforeEach(() => {
  sockets = [];
  heard.length = 0;
});

test("one message is under way, drags give way to newer ones, and the last goes before the end", async () => {
  const link = new Link("ws://here", told);
  const [socket] = sockets;
  const begun = link.send({ do: "begin" });
  const drags = [1, 2, 3].map((at) => link.send({ do: "drag", at }));
  const ended = link.send({ do: "end" });
  assert.deepEqual(socket.sent, [], "nothing before the line is open");
  socket.open();
  assert.deepEqual(socket.sent.map((one) => one.do), ["begin"]);
  socket.answer();
  assert.deepEqual(socket.sent.map((one) => one.at ?? one.do), ["begin", 3]);
  socket.answer();
  assert.equal(socket.sent.at(-1).do, "end");
  socket.answer();
  assert.equal((await begun).ok, true);
  const answers = await Promise.all(drags);
  assert.deepEqual(answers.map((one) => one.passed ?? false), [true, true, false]);
  assert.equal((await ended).ok, true);
});

test("news are told, and answers of others are not taken for ours", async () => {
  const link = new Link("ws://here", told);
  const [socket] = sockets;
  socket.open();
  const asked = link.send({ do: "undo" });
  socket.hear({ poses: {} });
  socket.hear({ n: 999, ok: true });
  assert.deepEqual(heard, [{ poses: {} }]);
  socket.answer();
  assert.equal((await asked).ok, true);
});

test("what waits when the line is lost is given up, and the line is opened again", async (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  const link = new Link("ws://here", told);
  sockets[0].open();
  const asked = [link.send({ do: "begin" }), link.send({ do: "end" })];
  sockets[0].onclose({ reason: "" });
  for (const answer of await Promise.all(asked)) assert.equal(answer.lost, true);
  context.mock.timers.tick(300);
  assert.equal(sockets.length, 2);
});

// Time between two requests for new ticks, ms, and after a request without an answer.
const POLL_MS = 100, RETRY_MS = 1000;

// Shows a drive that goes on: its newest tick, until the user selects another one.
async function followDrive(figure) {
  const newest = figure.querySelector("[data-action=live]"), lists = figure.querySelector(".event-lists");
  const state = document.getElementById("drive-state"), text = document.getElementById("drive-text");
  let isNewest = true;
  const player = startPlayer(figure, () => setNewest(false)), { playback } = player;

  function setNewest(on) {
    isNewest = on;
    newest.setAttribute("aria-pressed", on);
  }

  newest.addEventListener("click", () => {
    setNewest(true);
    player.show(playback.lastFrame);
  });

  function showState(name, isGood, sentence) {
    state.textContent = name;
    state.classList.toggle("good", isGood === true);
    state.classList.toggle("bad", isGood === false);
    if (text.textContent !== sentence) text.textContent = sentence;
  }

  // Fetches what the page does not know. Returns whether there is more: the program ends when a page has the whole drive.
  async function update() {
    const known = new URLSearchParams({ frames: playback.lastFrame + 1, shape: playback.shape, events: playback.events ?? "" });
    const { part, drive } = await (await fetch("/ticks?" + known)).json();
    player.append(part, isNewest ? Infinity : undefined);
    if (part.event_lists !== null) lists.innerHTML = part.event_lists;
    const operator = document.getElementById("operator-state");
    if (operator) operator.textContent = drive.operator;
    if (drive.end) showState("ended", drive.end.is_good, drive.end.text + ". The page keeps what it has until it is closed.");
    else showState("driving", null, "");
    return !drive.end || playback.lastFrame + 1 < drive.frames;
  }

  document.getElementById("stop")?.addEventListener("click", async () => {
    const answer = await fetch("/stop", { method: "POST", headers: { "Content-Type": "application/json" }, body: "{}" }).catch(() => null);
    if (!answer?.ok) showState("the stop did not arrive", false, "Stop the robot by other means.");
  });

  for (let goesOn = true; goesOn;) {
    let pause = POLL_MS;
    try {
      goesOn = await update();
    } catch {
      showState("no connection", false, "The program has ended or does not answer.");
      pause = RETRY_MS;
    }
    await new Promise((done) => { setTimeout(done, pause); });
  }
}

followDrive(document.querySelector(".player"));

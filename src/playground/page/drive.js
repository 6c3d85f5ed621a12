// Lets the whole navigator drive from the robot to the goal, and shows the page of the drive.

const find = (id) => document.getElementById(id);
const [panel, frame] = [find("driven"), find("drive-page")];
// Cancels the latest drive.
let latest = null;

// The request of a drive by a problem of the page. Its obstacles walk to and fro.
function driveOf(problem) {
  const { vx_samples, vtheta_samples, sampler, sim_time_s, weights, normalization, stopping } = problem;
  return {
    scene: problem.map.file, start: problem.robot.pose, goal: problem.target, people: problem.obstacles,
    vx_samples, vtheta_samples, sampler, sim_time_s, weights, normalization, stopping,
  };
}

// Cancels the drive that is being computed, and hides the last one.
export function clearDrive() {
  latest?.abort();
  panel.hidden = find("drive-result").hidden = true;
  frame.removeAttribute("src");
}

// Drives, and shows result, command and page in place of those before. `ask` sends a request.
export async function driveToGoal(problem, ask) {
  clearDrive();
  const { signal } = latest = new AbortController(), state = find("drive-state"), text = find("drive-text");
  const show = (badge, title, why) => {
    [state.className, state.textContent, text.textContent] = [badge, title, why];
    panel.hidden = false;
    panel.scrollIntoView();
  };
  show("badge", "computing the drive", "");
  try {
    const drive = await (await ask("/drive", driveOf(problem), signal)).json();
    signal.throwIfAborted();
    const isGood = drive.reached && !drive.collided;
    find("drive-command-label").textContent = drive.is_cut_off ? "This command drives on, without that limit:" : "This command repeats the drive:";
    find("drive-command").textContent = drive.command;
    find("drive-link").href = drive.page;
    find("drive-result").hidden = false;
    // The player scrolls to itself when it is loaded, past the result.
    frame.addEventListener("load", () => panel.scrollIntoView(), { once: true });
    frame.src = drive.page + "#mission-1&play";
    show("badge " + (isGood ? "good" : "bad"), isGood ? "goal reached" : drive.collided ? "contact" : "goal not reached",
      drive.why ?? `${drive.travelled_m.toFixed(1)} m in ${drive.time_s.toFixed(1)} s, smallest gap ${drive.min_clearance_m.toFixed(3)} m`);
  } catch (error) {
    if (!signal.aborted) show("badge bad", "no drive", error.message);
  }
}

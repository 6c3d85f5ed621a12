// Lets the whole navigator drive from the robot to the goal, and shows the page of the drive.

const find = (id) => document.getElementById(id);

// The request of a drive by a problem of the page. Its obstacles walk to and fro.
function driveOf(problem) {
  const { vx_samples, vtheta_samples, sampler, sim_time_s, weights, normalization, stopping } = problem;
  return {
    scene: problem.map.file, start: problem.robot.pose, goal: problem.target, people: problem.obstacles,
    vx_samples, vtheta_samples, sampler, sim_time_s, weights, normalization, stopping,
  };
}

// Drives, and shows result, command and page. `ask` sends a request.
export async function driveToGoal(problem, ask) {
  const button = find("drive"), state = find("drive-state"), text = find("drive-text");
  button.disabled = true;
  find("driven").hidden = false;
  [state.className, state.textContent, text.textContent] = ["badge", "computing the drive", ""];
  try {
    const drive = await (await ask("/drive", driveOf(problem))).json();
    const isGood = drive.reached && !drive.collided;
    state.className = "badge " + (isGood ? "good" : "bad");
    state.textContent = isGood ? "goal reached" : drive.collided ? "contact" : "goal not reached";
    text.textContent = drive.why ?? `${drive.travelled_m.toFixed(1)} m in ${drive.time_s.toFixed(1)} s, smallest gap ${drive.min_clearance_m.toFixed(3)} m`;
    find("drive-command").textContent = drive.command;
    find("drive-page").src = drive.page + "#mission-1&play";
    find("drive-link").href = drive.page;
    find("drive-result").hidden = false;
  } catch (error) {
    [state.className, state.textContent, text.textContent] = ["badge bad", "no drive", error.message];
    find("drive-result").hidden = true;
  }
  button.disabled = false;
}

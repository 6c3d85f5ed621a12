// Links to a moment of a drive: #mission-1&t=12.30. Without a section, a link means all players of the page. With &play they play
// from there.

// A link has two decimals, so its time may be this much before that of its frame; a little more than half of the last digit, seconds.
const LINK_ROUNDING_S = 0.0051;

// The time that the address selects in a section, seconds; undefined if it selects none.
function linkedTime(section) {
  const parts = location.hash.slice(1).split("&"), time = parts.map((part) => /^t=([\d.]+)$/.exec(part)).find(Boolean);
  const ids = parts.filter((part) => part && part !== "play" && !part.startsWith("t="));
  return time && (ids.length === 0 || ids.includes(section.id)) ? Number(time[1]) + LINK_ROUNDING_S : undefined;
}

// The fragment that selects a time in a section.
function momentFragment(section, time) {
  return "#" + section.id + "&t=" + time.toFixed(2);
}

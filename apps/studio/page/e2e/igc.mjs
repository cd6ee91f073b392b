// A generated log.

/** A glider's log: it climbs in circles and glides out, with a barometer whose scale is wrong by 2 %. */
export function igc(pilot, glider) {
  const lines = ["AXXX001 made by a test", "HFDTE010624", `HFPLTPILOTINCHARGE:${pilot}`, `HFGTYGLIDERTYPE:${glider}`, `HFGIDGLIDERID:${glider}`];
  const two = (value) => String(value).padStart(2, "0");
  for (let s = 0; s < 1500; s += 1) {
    const height = 600 + (s < 60 ? 0 : s < 800 ? (s - 60) * 1.6 : 1184 - (s - 800) * 1.3) + 8 * Math.sin(s / 11);
    const moved = s < 60 ? 0 : s;
    const north = 20_000 + Math.round(moved * 4 + (s < 60 ? 0 : 60 * Math.sin(s / 4)));
    const east = 20_000 + Math.round(moved * 3 + (s < 60 ? 0 : 90 * Math.cos(s / 4)));
    const clock = `${two(10 + Math.floor(s / 3600))}${two(Math.floor(s / 60) % 60)}${two(s % 60)}`;
    const level = (value) => String(Math.round(value)).padStart(5, "0");
    lines.push(`B${clock}47${String(north).padStart(5, "0")}N008${String(east).padStart(5, "0")}EA${level(height * 1.02 + 20)}${level(height + 2 * Math.sin(s / 70))}`);
  }
  return `${lines.join("\r\n")}\r\n`;
}

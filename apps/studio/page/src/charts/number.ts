// Numbers as the page writes them.

/** With decimals for three significant figures, without an exponent where a person would write none. */
export function short(value: number): string {
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size >= 1e6 || size < 1e-4) return value.toExponential(1).replace("-", "−");
  const digits = size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : Math.min(6, 2 - Math.floor(Math.log10(size)));
  return value.toFixed(digits).replace("-", "−");
}

/** A length in metres. These sensors can't resolve centimetres. */
export function metres(value: number): string {
  const size = Math.abs(value);
  const digits = size >= 100 ? 0 : size >= 0.95 ? 1 : 2;
  return `${value.toFixed(digits).replace("-", "−")} m`;
}

/** A coefficient and its sigma with the same number of decimals: two figures of the sigma. */
export function withSigma(value: number, sigma: number): string {
  if (!(sigma > 0) || !Number.isFinite(sigma)) return short(value);
  return `${value.toFixed(decimals(sigma)).replace("-", "−")} ± ${sigmaText(sigma)}`;
}

/** A sigma with two figures. */
export function sigmaText(sigma: number): string {
  return sigma.toFixed(decimals(sigma));
}

function decimals(sigma: number): number {
  return Math.max(0, Math.min(8, 1 - Math.floor(Math.log10(sigma))));
}

export function percent(share: number): string {
  if (share > 0 && share < 0.01) return "< 1 %";
  if (share < 1 && share > 0.99) return "> 99 %";
  return `${Math.round(share * 100)} %`;
}

/**
 * A time of the flight's clock, or a duration: below two minutes in seconds, else minutes or hours with
 * seconds.
 */
export function clock(seconds: number): string {
  const sign = seconds < 0 ? "−" : "";
  const size = Math.abs(seconds);
  if (size < 120) return `${sign}${size.toFixed(size < 10 && size % 1 !== 0 ? 1 : 0)} s`;
  const whole = Math.round(size);
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor((whole % 3600) / 60), whole % 60];
  const two = (value: number): string => String(value).padStart(2, "0");
  return h > 0 ? `${sign}${h}:${two(m)}:${two(s)} h` : `${sign}${m}:${two(s)} min`;
}

/** A time as written on the axis: 2:09. */
export function moment(seconds: number): string {
  const size = Math.abs(Math.round(seconds));
  const [hours, minutes, rest] = [Math.floor(size / 3600), Math.floor((size % 3600) / 60), size % 60];
  const two = (part: number): string => String(part).padStart(2, "0");
  return `${seconds < 0 ? "−" : ""}${hours > 0 ? `${hours}:${two(minutes)}` : minutes}:${two(rest)}`;
}

/** A unit as it is written after a number; empty for "1". */
export function unit(name: string): string {
  return name === "1" || name === "" ? "" : ` ${name.replace("^2", "²").replace("^3", "³")}`;
}

// What is written at the ticks of an axis.

/** As many decimals as the step needs, so that no two texts are alike. */
export function tickTexts(ticks: number[]): string[] {
  const steps = ticks.slice(1).map((tick, index) => Math.abs(tick - (ticks[index] ?? 0)));
  const step = Math.min(...steps.filter((one) => one > 0), 1);
  const decimals = Math.min(Math.max(Math.ceil(-Math.log10(step) - 1e-9), 0), 9);
  const enough = decimals < 9 && steps.some((one) => Math.abs(one * 10 ** decimals - Math.round(one * 10 ** decimals)) > 1e-6);
  return ticks.map((tick) => tick.toFixed(enough ? decimals + 1 : decimals));
}

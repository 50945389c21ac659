// Lines over time, in the page's colours.
import UPlot from "uplot";
import "uplot/dist/uPlot.min.css";

export const LINE_COLORS = ["#4b9dff", "#ff9e4a", "#4cc38a", "#f0616d", "#c58bff", "#4ecdc4", "#ffd65c", "#9aa7b5"];

export interface Line {
  color: string;
  show: boolean;
  dashed?: boolean;
}

/** Draws into `host`, as large as it is; `close` ends it. */
export function chart(host: HTMLElement, unit: string, lines: readonly Line[], more: Partial<UPlot.Options> = {}): { plot: UPlot; close: () => void } {
  const style = getComputedStyle(document.documentElement);
  const axis: UPlot.Axis = {
    stroke: style.getPropertyValue("--muted"),
    font: "10.5px 'Inter Variable'",
    grid: { stroke: style.getPropertyValue("--line"), width: 1 },
    ticks: { show: false },
  };
  const options: UPlot.Options = {
    width: host.clientWidth || 300,
    height: host.clientHeight || 120,
    padding: [10, 14, 0, 0],
    legend: { show: false },
    scales: { x: { time: false } },
    axes: [
      { ...axis, size: 24, values: (_, values) => values.map((value) => `${value} s`) },
      { ...axis, size: 52, space: 20, values: (_, values) => values.map((value) => `${value}${unit}`) },
    ],
    series: [{}, ...lines.map(({ color, show, dashed }) => ({
      stroke: color, width: 1.6, points: { show: false }, show, dash: dashed ? [4, 4] : undefined, spanGaps: true,
    }))],
    ...more,
  };
  const plot = new UPlot(options, [[], ...lines.map(() => [])], host);
  const sized = new ResizeObserver(() => plot.setSize({ width: host.clientWidth, height: host.clientHeight }));
  sized.observe(host);
  return {
    plot,
    close: () => {
      sized.disconnect();
      plot.destroy();
    },
  };
}

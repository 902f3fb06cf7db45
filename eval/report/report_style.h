// The style sheet of a report; private to eval/report.
#ifndef CAIRN_EVAL_REPORT_REPORT_STYLE_H_
#define CAIRN_EVAL_REPORT_REPORT_STYLE_H_

namespace cairn {

// Two schemes of the same colors. Those of the grades are told apart by people who do not see red
// and green alike (Okabe and Ito), and each grade stands as a word, too.
inline constexpr char kReportStyle[] = R"css(
:root { --paper: #fcfbfa; --ink: #202428; --pale: #6b7178; --grid: #d9dcdf; --series1: #0072b2;
  --series2: #b35900; --fine: #00795a; --good: #0072b2; --fair: #9a6a00; --wrong: #c1331b;
  --none: #8a3f78; --landmark: #b9bec4; --keyframe: #6b7178; --tile: #f0efec; }
@media (prefers-color-scheme: dark) {
  :root { --paper: #16181b; --ink: #e8eaec; --pale: #a0a7ae; --grid: #383d43; --series1: #56b4e9;
    --series2: #f0a050; --fine: #3fd0a0; --good: #56b4e9; --fair: #e6b422; --wrong: #ff7a5c;
    --none: #df93cb; --landmark: #4a5057; --keyframe: #a0a7ae; --tile: #1e2125; }
}
body { background: var(--paper); color: var(--ink); font: 15px/1.5 system-ui, sans-serif;
  margin: 0 auto; max-width: 1000px; padding: 0 20px 60px; }
h1 { font-size: 26px; margin: 28px 0 4px; overflow-wrap: anywhere; }
h2 { border-top: 1px solid var(--grid); font-size: 20px; margin: 36px 0 12px; padding-top: 16px; }
h3 { font-size: 15px; margin: 0 0 6px; }
p { margin: 6px 0; }
a { color: var(--series1); }
nav a { margin-right: 14px; }
.note, figcaption { color: var(--pale); font-size: 13px; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th { font-weight: normal; text-align: left; }
th, td { border-bottom: 1px solid var(--grid); padding: 3px 12px 3px 0; }
td { text-align: right; }
thead { color: var(--pale); }
table.all { display: block; font-size: 13px; overflow-x: auto; }
td.mark { text-align: left; color: var(--grade); }
tr:target, figure:target { outline: 2px solid var(--series1); }
figure { margin: 0 0 24px; }
figure img, svg.frameless { display: block; width: 100%; }
svg.frameless { border: 1px solid var(--grid); }
.charts { display: grid; gap: 20px; grid-template-columns: repeat(auto-fit, minmax(min(100%, 420px), 1fr)); }
svg.chart, svg.plan { display: block; height: auto; width: 100%; }
svg.plan { border: 1px solid var(--grid); }
svg text { fill: var(--ink); font: 12px system-ui, sans-serif; }
svg text.note { fill: var(--pale); }
.grid, .frame { fill: none; stroke: var(--grid); }
.reference { stroke: var(--pale); stroke-dasharray: 4 4; }
.s1 { --series: var(--series1); }
.s2 { --series: var(--series2); }
.line { fill: none; stroke: var(--series); stroke-width: 2; }
.band { fill: var(--series); opacity: .22; }
.dot { fill: var(--series); }
.fine { --grade: var(--fine); }
.good { --grade: var(--good); }
.fair { --grade: var(--fair); }
.wrong { --grade: var(--wrong); }
.none { --grade: var(--none); }
.grades span { color: var(--grade); margin-right: 16px; white-space: nowrap; }
.tile { fill: var(--tile); stroke: var(--grid); }
.landmarks { fill: none; stroke: var(--landmark); stroke-width: 1; }
.keyframes { fill: none; stroke: var(--keyframe); stroke-linecap: round; stroke-width: 4; }
.rays { fill: none; stroke: var(--keyframe); }
.inliers { fill: none; stroke: var(--series1); stroke-linecap: round; stroke-width: 7; }
.truth { fill: none; stroke: var(--grade); stroke-width: 2; }
.answer { fill: var(--grade); }
.ray { fill: none; stroke: var(--grade); stroke-width: 1.5; }
.scale { fill: none; stroke: var(--ink); }
a:hover .truth { stroke-width: 4; }
)css";

}  // namespace cairn

#endif  // CAIRN_EVAL_REPORT_REPORT_STYLE_H_

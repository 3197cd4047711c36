#include "show/page/style.h"

namespace pleat::show {

// Series colours follow color.h: s0 simulated, s1 sampled, s2 reconstructed.
const char* const kPageStyle = R"css(
:root {
  color-scheme: light dark;
  --paper: #ffffff; --ink: #22262b; --soft: #626a73; --rule: #e2e3e0; --panel: #f6f5f2;
  --s0: #3f6fa3; --s1: #c9643f; --s2: #2f8577; --s3: #8b5fa8; --s4: #a57c12; --s5: #6a737c;
  --serif: Charter, "Bitstream Charter", "Sitka Text", Cambria, "Noto Serif", Georgia, serif;
  --sans: system-ui, -apple-system, "Segoe UI", "Noto Sans", "Liberation Sans", "DejaVu Sans", sans-serif;
  --mono: ui-monospace, "SFMono-Regular", Menlo, Consolas, "DejaVu Sans Mono", monospace;
}
@media (prefers-color-scheme: dark) {
  :root {
    --paper: #15181b; --ink: #dfe2e4; --soft: #979fa7; --rule: #2e3337; --panel: #1d2125;
    --s0: #7aa9da; --s1: #e58a63; --s2: #5bb8a7; --s3: #b892d2; --s4: #d3ab45; --s5: #9aa3ab;
  }
  img { filter: brightness(0.88); }
}
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; text-size-adjust: 100%; }
body { margin: 0; background: var(--paper); color: var(--ink); font: 1.0625rem/1.6 var(--serif);
       overflow-wrap: break-word; }
header, main, footer { max-width: 62rem; margin: 0 auto; padding: 0 1.25rem; }
header { padding-top: 3.5rem; }
h1 { font-size: clamp(1.7rem, 5vw, 2.5rem); line-height: 1.15; font-weight: 600; letter-spacing: -0.012em;
     margin: 0; text-wrap: balance; }
.subtitle { color: var(--soft); font-size: 1.15rem; margin: 0.6rem 0 0; max-width: 42rem; }
nav { font: 0.875rem/1.5 var(--sans); margin-top: 1.5rem; display: flex; flex-wrap: wrap; gap: 0.2rem 1.25rem;
      padding-bottom: 0.9rem; border-bottom: 1px solid var(--rule); }
nav a { color: var(--soft); text-decoration: none; }
nav a:hover, nav a:focus { color: var(--ink); text-decoration: underline; text-underline-offset: 0.25em; }
section { margin: 3rem 0 0; }
h2 { font-size: 1.4rem; line-height: 1.25; font-weight: 600; margin: 0 0 0.9rem; }
p { max-width: 42rem; margin: 0 0 1rem; }
figure { margin: 1.5rem 0; }
figcaption { font: 0.875rem/1.5 var(--sans); color: var(--soft); text-align: left; max-width: 46rem; }
figcaption { margin-top: 0.6rem; }
figcaption.above { margin: 0 0 0.4rem; }

.headline { display: grid; grid-template-columns: repeat(auto-fit, minmax(8.5rem, 1fr)); gap: 1.25rem;
            margin: 1.5rem 0; padding: 0; }
.headline div { display: flex; flex-direction: column-reverse; justify-content: flex-end;
                border-top: 2px solid var(--ink); padding-top: 0.45rem; }
.headline dt { font: 0.8125rem/1.4 var(--sans); color: var(--soft); }
.headline dd { margin: 0; font-size: 1.5rem; line-height: 1.3; font-variant-numeric: tabular-nums; }

.facts { display: grid; grid-template-columns: minmax(7rem, max-content) 1fr; gap: 0.25rem 1.5rem;
         font: 0.875rem/1.5 var(--sans); margin: 1rem 0; }
.facts div { display: contents; }
.facts dt { color: var(--soft); }
.facts dd { margin: 0; min-width: 0; overflow-wrap: anywhere; }

.scroll { overflow-x: auto; }
table { border-collapse: collapse; font: 0.875rem/1.5 var(--sans); font-variant-numeric: tabular-nums; }
th, td { padding: 0.35rem 1.4rem 0.35rem 0; text-align: left; vertical-align: top; }
th:last-child, td:last-child { padding-right: 0; }
th { font-weight: 600; border-bottom: 1px solid var(--ink); vertical-align: bottom; }
th small { display: block; font-size: 0.8125rem; font-weight: 400; color: var(--soft); }
td { border-bottom: 1px solid var(--rule); }
.number { text-align: right; white-space: nowrap; }

.pictures { overflow-x: auto; }
.grid { display: grid; gap: 0.5rem; align-items: start; }
.grid .column { font: 600 0.8125rem/1.35 var(--sans); align-self: end; }
.grid .row { grid-column: 1 / -1; font: 0.8125rem/1.35 var(--sans); color: var(--soft); margin-top: 0.7rem; }
.grid figure { margin: 0; }
.grid img { display: block; width: 100%; height: auto; border-radius: 3px; }
.grid figcaption { margin-top: 0.25rem; font-size: 0.8125rem; line-height: 1.35;
                   font-variant-numeric: tabular-nums; }
.grid .missing { background: var(--panel); border: 1px dashed var(--rule); border-radius: 3px; min-height: 6rem;
                 padding: 0.6rem; }
.pixelated img { image-rendering: pixelated; }
.colorbar { display: flex; align-items: center; gap: 0.6rem; font: 0.8125rem/1.4 var(--sans); color: var(--soft);
            margin-top: 0.8rem; flex-wrap: wrap; font-variant-numeric: tabular-nums; }
.colorbar svg { width: 11rem; height: 0.7rem; border-radius: 2px; }

.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr)); gap: 0 2rem; }
.chart { margin: 1.2rem 0; max-width: 36rem; min-width: 0; }
.chart svg { display: block; width: 100%; height: auto; font-family: var(--sans); }
.chart .gridline { stroke: var(--rule); stroke-width: 1; }
.chart .axis { stroke: var(--soft); stroke-width: 1; }
.chart .tick, .chart .label { fill: var(--soft); font-size: 12.5px; font-variant-numeric: tabular-nums; }
.chart .line { fill: none; stroke: var(--s); stroke-width: 1.75; stroke-linejoin: round; stroke-linecap: round; }
.chart .dot { fill: var(--s); }
.s0 { --s: var(--s0); } .s1 { --s: var(--s1); } .s2 { --s: var(--s2); }
.s3 { --s: var(--s3); } .s4 { --s: var(--s4); } .s5 { --s: var(--s5); }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: 0.15rem 1.2rem; margin: 0.4rem 0 0; padding: 0;
          font: 0.8125rem/1.5 var(--sans); }
.legend i { display: inline-block; width: 1.1rem; height: 0.2rem; border-radius: 1px; background: var(--s);
            vertical-align: 0.25em; margin-right: 0.45rem; }

details { margin: 1.25rem 0; font: 0.875rem/1.5 var(--sans); border-top: 1px solid var(--rule);
          border-bottom: 1px solid var(--rule); padding: 0.6rem 0; }
summary { cursor: pointer; }
pre { font: 0.8125rem/1.5 var(--mono); overflow-x: auto; background: var(--panel); padding: 1rem; margin: 0.75rem 0 0;
      border-radius: 3px; tab-size: 2; }
footer { margin-top: 3.5rem; padding-bottom: 3rem; }
footer .facts { border-top: 1px solid var(--rule); padding-top: 1rem; font-size: 0.8125rem; color: var(--soft); }

@media (max-width: 40rem) {
  body { font-size: 1rem; }
  header { padding-top: 2rem; }
  section { margin-top: 2.25rem; }
  .grid { gap: 0.35rem; }
  .facts { grid-template-columns: 1fr; gap: 0; }
  .facts dd { margin-bottom: 0.5rem; }
}
@media print {
  :root { --paper: #fff; --ink: #000; --soft: #444; --rule: #ccc; --panel: #f4f4f4;
          --s0: #3f6fa3; --s1: #c9643f; --s2: #2f8577; --s3: #8b5fa8; --s4: #a57c12; --s5: #6a737c; }
  body { font-size: 10pt; }
  header, main, footer { max-width: none; padding: 0; }
  nav { display: none; }
  img { filter: none; }
  figure, tr, .headline div { break-inside: avoid; }
  .grid figure { break-inside: avoid; }
  .pictures { overflow: visible; }
  h2 { break-after: avoid; }
}
)css";

}  // namespace pleat::show

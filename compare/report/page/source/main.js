import {element} from "./dom.js";
import {bench} from "./bench.js";
import {check} from "./check.js";
import {compare} from "./compare.js";
import {furnace} from "./furnace.js";
import {furnaceSweep} from "./furnace_sweep.js";
import {sweep} from "./sweep.js";

const read = (id) => JSON.parse(document.getElementById(id).textContent);
const answer = read("answer"), details = read("details");
const page = document.getElementById("page");
page.replaceChildren();
({bench, check, compare, furnace: answer.sweep ? furnaceSweep : furnace, sweep})[answer.command](page, answer, details);
document.getElementById("footer").prepend(element("p", {},
  `Written by lamella ${answer.version}. All numbers and plots are in this file; nothing is loaded from elsewhere.`));
performance.mark("ready");
document.documentElement.dataset.ready = "true";

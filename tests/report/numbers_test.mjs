import assert from "node:assert/strict";
import {test} from "node:test";
import {luminance, percent} from "../../compare/report/page/source/numbers.js";

test("percent has two digits and no powers of ten, as the program's tables have", () => {
  for (const [share, text] of [[0, "0 %"], [.41, "41 %"], [.0083, "0.83 %"], [.083, "8.3 %"], [.0996, "10 %"], [.09949, "9.9 %"],
    [1.2, "120 %"], [1.234, "123 %"], [84.7, "8470 %"], [9999.99, "999999 %"], [1e17, "above 1000000 %"],
    [-1e17, "below −1000000 %"], [1.5e-7, "0.000015 %"], [1e-12, "below 0.00000001 %"], [-.5, "−50 %"],
    ["inf", "∞"], [Infinity, "∞"], [null, "–"], [NaN, "–"]]) assert.equal(percent(share), text, `${share}`);
  for (let share = 1e-30; share < 1e30; share *= 1.7) assert.doesNotMatch(percent(share), /\de|·|10[⁰-⁹]/);
});

test("a colour's one number is its luminance", () => {
  assert.equal(luminance([.7]), .7);
  assert.ok(Math.abs(luminance([.9, .5, .2]) - (.2126 * .9 + .7152 * .5 + .0722 * .2)) < 1e-15);
});

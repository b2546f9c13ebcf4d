// Words of the profiles that ship, as they read in a form; what else a profile says stays as it is.

import { t } from "./texts.js";

/** Return a name of a parameter, or one of its choices, in the reader's language. */
export function word(said) {
  const words = {
    Angle: t("Angle"),
    Direction: t("Direction"),
    Distance: t("Distance"),
    "For how long": t("For how long"),
    Force: t("Force"),
    Forward: t("Forward"),
    Heading: t("Heading"),
    Height: t("Height"),
    Joint: t("Joint"),
    Pose: t("Pose"),
    Shape: t("Shape"),
    Spacing: t("Spacing"),
    Speed: t("Speed"),
    "To the angle": t("To the angle"),
    "To the left": t("To the left"),
    "Turning left": t("Turning left"),
    Whom: t("Whom"),
    back: t("back"),
    column: t("column"),
    forward: t("forward"),
    left: t("left"),
    line: t("line"),
    right: t("right"),
    triangle: t("triangle"),
  };
  return Object.hasOwn(words, said) ? words[said] : said;
}

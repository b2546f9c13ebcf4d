"""256 short words to compare by eye or by ear: no two sound or look alike, none offends.

Their order is part of what two sides compare: a word is never moved, only replaced.
"""

from __future__ import annotations

from typing import Final

# fmt: off
WORDS: Final = (
    "acorn", "almond", "amber", "anchor", "apple", "arrow", "atlas", "autumn", "badge",
    "bamboo", "banana", "banjo", "barley", "barn", "basket", "beach", "beaver", "berry",
    "bicycle", "biscuit", "bison", "blossom", "bonus", "bottle", "boulder", "bread", "breeze",
    "brick", "brush", "bubble", "butter", "cabin", "cactus", "camel", "candle", "canvas",
    "carpet", "cashew", "cedar", "cello", "chalk", "cherry", "chess", "circus", "clock",
    "clover", "cobalt", "cobweb", "coconut", "coffee", "cookie", "copper", "cotton", "crane",
    "crayon", "cricket", "crown", "crystal", "cushion", "cycle", "daisy", "desert", "diamond",
    "dolphin", "domino", "dove", "drawer", "drizzle", "drum", "eagle", "easel", "echo",
    "emerald", "engine", "falcon", "feather", "fern", "fiddle", "finch", "flame", "flannel",
    "forest", "fossil", "fridge", "furrow", "galaxy", "gallery", "garden", "garlic", "gecko",
    "ginger", "giraffe", "glacier", "glitter", "globe", "gondola", "granite", "grape",
    "guitar", "hammer", "harp", "hazel", "hedge", "helmet", "heron", "hill", "hippo",
    "hollow", "honey", "igloo", "indigo", "insect", "iris", "island", "ivory", "jacket",
    "jaguar", "jelly", "jewel", "jigsaw", "juice", "jungle", "kayak", "kettle", "kite",
    "koala", "ladder", "lagoon", "larch", "lemon", "lentil", "lilac", "lime", "lizard",
    "lotus", "lunar", "lynx", "magnet", "magpie", "mango", "marble", "meadow", "melon",
    "meteor", "mint", "mirror", "mitten", "mosaic", "moss", "muffin", "museum", "napkin",
    "nectar", "needle", "nest", "nickel", "nugget", "nutmeg", "oasis", "ocean", "olive",
    "onion", "opal", "orange", "orbit", "orchid", "otter", "paddle", "palace", "panda",
    "papaya", "paper", "parcel", "parrot", "pear", "pebble", "pencil", "piano", "picnic",
    "pigeon", "pillow", "planet", "plum", "pocket", "pony", "potato", "puzzle", "quartz",
    "quilt", "quiver", "rabbit", "radio", "raft", "raisin", "raven", "reef", "ribbon",
    "robin", "rope", "ruby", "salad", "salmon", "sandal", "satin", "saucer", "scarf", "shell",
    "shovel", "silver", "skate", "sketch", "snow", "soap", "spider", "sponge", "spoon",
    "squid", "stable", "storm", "summer", "syrup", "teapot", "temple", "tennis", "ticket",
    "tiger", "toast", "tomato", "topaz", "train", "trout", "tulip", "tundra", "tunnel",
    "turtle", "twig", "valley", "vase", "velvet", "violin", "waffle", "wagon", "wallet",
    "walrus", "water", "whale", "wheat", "whisk", "window", "wool", "yacht", "yellow",
    "zebra", "zenith", "zigzag", "zinnia",
)
# fmt: on

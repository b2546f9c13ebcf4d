"""A fleet as a value machine: tasks, who carries them out, and what has to happen next.

Pure: it is fed what happened and returns what is so from now on and what is to be done; nothing of
it moves a robot. `rosic.features.fleet` carries out what it decides, each attempt as an order.
"""

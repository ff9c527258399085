"""Learns the network that proposes joints (`topview.detect.joints`) from recordings with truth.

`recordings` reads them into a cache, `windows` makes windows of them as the tracker would see them
and varies these, `net` is the network, `learning` the loop, `export` writes what the tracker loads.
Only `net`, `learning` and `export` need torch.
"""

"""The figures and tables of the thesis, made again from data that anybody can make.

`catalogue` lists them; each is a module of its own. `printed` holds the thesis's numbers.
"""

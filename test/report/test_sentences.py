"""
Where the report's verdicts and result sentences come from: a search of its source.

Run as a script it prints each with the expression that makes it.
"""
import ast
from pathlib import Path
import re

from bristle_ros.report.verdict import WORDS
import pytest

REPORT = Path(__file__).resolve().parent.parent.parent / 'bristle_ros' / 'report'
SOURCES = {str(path.relative_to(REPORT)): ast.parse(path.read_text(encoding='utf-8'))
           for path in sorted(REPORT.rglob('*.py'))}
MAKERS = {'at_least', 'at_most', 'between', 'every', 'either'}
# Words that only a result can have, in a text that no value of a run goes into.
RESULTS = re.compile(
    r'\b(?:is|are|was|gets?|runs?) (?:the )?(?:faster|slower|better|worse|cheaper|stable)\b'
    r'|\b(?:stays|agrees?|rings|outperforms|diverges)\b|\brepeats only\b'
    r'|times (?:faster|slower|real time)\b.*\d|\d.*times (?:faster|slower|real time)'
    r'|\b(?:because of|caused by|due to)\b|\d ?% (?:better|worse|faster|slower)')
# How a figure or a table is read.
DEFINED = ('lower left is better', 'above 1 ours is the faster', 'is faster than real time',
           'times real time on one core; on all')


def calls(tree, name):
    """Return the calls of a method or function of that name."""
    return [node for node in ast.walk(tree) if isinstance(node, ast.Call)
            and getattr(node.func, 'attr', getattr(node.func, 'id', None)) == name]


def docstrings(tree):
    """Return the nodes of docstrings."""
    return {id(node.body[0].value) for node in ast.walk(tree)
            if isinstance(node, (ast.Module, ast.FunctionDef, ast.ClassDef)) and node.body
            and isinstance(node.body[0], ast.Expr)}


def texts(tree):
    """Return the constant texts of a module, without docstrings."""
    skip = docstrings(tree)
    for node in ast.walk(tree):     # with a value in it, it is made from that value
        if isinstance(node, ast.JoinedStr) and any(isinstance(part, ast.FormattedValue)
                                                   for part in node.values):
            skip |= {id(part) for part in node.values}
    return [node for node in ast.walk(tree) if isinstance(node, ast.Constant)
            and isinstance(node.value, str) and id(node) not in skip]


def is_made(node):
    """Whether an expression depends on something: no constant, alone or in pieces."""
    return any(isinstance(part, (ast.FormattedValue, ast.Call, ast.Name, ast.Attribute))
               for part in ast.walk(node))


@pytest.mark.parametrize('name', SOURCES)
def test_verdict_words_stand_in_one_place(name):
    found = [node.value for node in texts(SOURCES[name])
             if any(re.search(rf'\b{word}\b', node.value) for word in WORDS)]
    assert not found or name == 'verdict.py', found


def test_every_claim_has_a_verdict_from_an_expression():
    rows = calls(SOURCES['paper/claims.py'], '_row')
    assert len(rows) >= 12
    for row in rows:
        made = row.args[3]
        assert isinstance(made, ast.Call), ast.unparse(row)
        assert made.func.id in MAKERS | {'_good'}, ast.unparse(made)


@pytest.mark.parametrize('name', SOURCES)
def test_what_is_said_is_made_from_values(name):
    for call in calls(SOURCES[name], 'says'):
        assert is_made(call.args[0]), ast.unparse(call)


@pytest.mark.parametrize('name', SOURCES)
def test_fixed_texts_say_no_result(name):
    for node in texts(SOURCES[name]):
        found = RESULTS.search(node.value)
        assert not found or any(part in node.value for part in DEFINED), node.value


def test_the_search_can_find():
    for text in ('the error stays, at any step', 'an undamped path repeats only on average',
                 'ours is faster', '46 times real time', 'it never diverges'):
        assert RESULTS.search(text), text
    assert not is_made(ast.parse("page.says('a' 'b')").body[0].value.args[0])


if __name__ == '__main__':
    for source, module in SOURCES.items():
        for kind in ('_row', 'says'):
            for call in calls(module, kind):
                place = 3 if kind == '_row' else 0
                print(f'{source}:{call.lineno}: {ast.unparse(call.args[place])}')

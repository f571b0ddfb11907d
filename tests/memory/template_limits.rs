//! Filling a template takes bounded memory and work, whatever it says, and ends with an error that names the limit.

use super::{MEMORY, alone};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use nearmiss::prompts::{RenderError, Template, render};

/// More than any filling may take beyond what it is given, bytes.
const MOST: usize = 64 << 20;

/// Far more than it takes on a slow machine that others use too.
const LONGEST: Duration = Duration::from_secs(20);

/// What only ends because a limit stops it.
const ENDLESS: &[&str] = &[
    "{{ 'x'|indent(1000000000, true) }}",
    "{{ 'a\nb'|indent(width=4000000000, first=true) }}",
    "{{ '%1000000000d'|format(1) }}",
    "{{ '%-999999999s|'|format('a') }}",
    "{{ '%*d'|format(1000000000, 1) }}",
    "{{ '%.900000000f'|format(1.5) }}",
    "{% set n = '%' ~ 1000000000 ~ 'd' %}{{ n|format(7) }}",
    "{{ ('x' * 100000)|replace('x', 'y' * 100000) }}",
    "{{ ('x' * 100000)|replace('', 'y' * 100000) }}",
    "{{ range(100000)|join('x' * 100000) }}",
    "{{ range(10)|batch(1000000000, 'x') }}",
    "{{ range(10)|slice(1000000000) }}",
    "{{ [1]|batch(50000000, [1, 2, 3])|list|length }}",
    "{{ 'x' * 1000000000 }}",
    "{{ 'x' * 99999999 }}",
    "{{ 10 ** 9 * 'x' }}",
    "{% set s = 'x' * 90000000 %}",
    "{{ [1, 2] * 90000000 }}",
    "{{ ([1] * 40000000)|length }}",
    "{{ ((1, 2) * 40000000)|length }}",
    "{% set s = namespace(v='xxxxxxxxxx') %}{% for i in range(60) %}{% set s.v = s.v ~ s.v %}{% endfor %}{{ s.v }}",
    "{% set s = namespace(v='xxxxxxxxxx') %}{% for i in range(60) %}{% set s.v = s.v + s.v %}{% endfor %}{{ s.v|length }}",
    "{% set s = namespace(v=[1]) %}{% for i in range(60) %}{% set s.v = s.v + s.v %}{% endfor %}{{ s.v|length }}",
    "{% set s = namespace(v=[1]) %}{% for i in range(60) %}{% set s.v = [s.v, s.v] %}{% endfor %}{{ s.v }}",
    "{% set s = namespace(v={}) %}{% for i in range(60) %}{% set s.v = {'a': s.v, 'b': s.v} %}{% endfor %}{{ s.v }}",
    "{% set s = namespace(v=[1]) %}{% for i in range(100000) %}{% set s.v = [s.v] %}{% endfor %}{{ s.v }}",
    "{% set s = namespace(v=[1]) %}{% for i in range(100000) %}{% set s.v = s.v|chain([i]) %}{% endfor %}",
    "{% set s = namespace(v={}) %}{% for i in range(100000) %}{% set s.v = s.v|chain({i: i}) %}{% endfor %}",
    "{% set s = namespace(v=range(9)) %}{% for i in range(100000) %}{% set s.v = s.v[0:]|reverse|map('string') %}{% endfor %}",
    "{% set s = namespace(v='x') %}{% for i in range(60) %}{% set s.v %}{{ s.v }}{{ s.v }}{% endset %}{% endfor %}",
    "{% set s = namespace(v='x') %}{% for i in range(60) %}{% set s.v = '%s%s'|format(s.v, s.v) %}{% endfor %}",
    "{% set s = namespace(v='x') %}{% for i in range(60) %}{% set s.v = [s.v, s.v]|join %}{% endfor %}",
    "{% set s = namespace(v='x') %}{% for i in range(60) %}{% set s.v = s.v|replace('x', 'xx') %}{% endfor %}",
    "{% set s = namespace(v='ŉ') %}{% for i in range(60) %}{% set s.v = (s.v ~ s.v)|upper|title %}{% endfor %}",
    "{% set s = namespace(v='<') %}{% for i in range(60) %}{% set s.v = s.v|escape|string|escape|replace(';', '<<') %}{% endfor %}",
    "{% set s = namespace(v='\n') %}{% for i in range(60) %}{% set s.v = (s.v ~ s.v)|indent(8, true, true) %}{% endfor %}",
    "{% set s = namespace(v='x') %}{% for i in range(60) %}{% set s.v = [s.v, s.v]|sum(start='') %}{% endfor %}",
    "{% set s = namespace(v=[1]) %}{% for i in range(60) %}{% set s.v = s.v|zip(s.v)|list %}{% set s.v = [s.v, s.v]|pprint %}{% endfor %}",
    "{% set s = namespace(v='x') %}{% for i in range(60) %}{% set s.v = debug(s.v, s.v) %}{% endfor %}",
    "{% macro m(s) %}{{ m(s ~ s) }}{% endmacro %}{{ m('xxxxxxxxxxxxxxxx') }}",
    "{% macro m(n) %}{{ m(n) }}{{ m(n) }}{% endmacro %}{{ m(1) }}",
    "{% macro m(s) %}{{ s }}{{ caller() }}{{ caller() }}{% endmacro %}{% macro r(n) %}{% call m('x') %}{{ r(n) }}{{ r(n) }}{% endcall %}{% endmacro %}{{ r(1) }}",
    "{% for a in range(99999) %}{% for b in range(99999) %}{{ a }}{% endfor %}{% endfor %}",
    "{% for a in range(99999) %}{% for b in range(99999) %}0123456789012345678901234567890123456789{% endfor %}{% endfor %}",
    "{% for a in range(99999) %}{{ description }}{% endfor %}",
    "{% for a in range(99999) %}{{ description|length }}{% endfor %}",
    "{% for a in range(99999) %}{% if description ~ a == description %}a{% endif %}{% endfor %}",
    "{% for a in range(99999) %}{% if 'zzz' in description %}a{% endif %}{% endfor %}",
    "{% for a in range(99999) %}{{ loop.cycle(description, description|upper) }}{% endfor %}",
    "{% for a in range(99999) %}{% filter upper %}{{ description }}{% endfilter %}{% endfor %}",
    "{% for a in range(99999) %}{% set x = dict(a=description ~ a) %}{% endfor %}",
    "{% for a in range(99999) %}{% set x = description|list|unique|sort %}{% endfor %}",
    "{% for a in range(99999) %}{% set x = range(99999)|groupby('real', default=1) %}{% endfor %}",
    "{% for a in range(99999) %}{% set x = range(99999)|map('string')|join %}{% endfor %}",
    "{% for a in range(99999) %}{% macro m() %}{{ a }}{% endmacro %}{% endfor %}",
    "{% for a in range(99999) %}{% include '_f.md' %}{% endfor %}",
    "{% include '_self.md' %}",
    "{% include '_twice.md' %}",
    "{% for x in [[1]] recursive %}{{ loop([x, x]) }}{% endfor %}",
    "{% autoescape true %}{% for a in range(99999) %}{{ description }}{% endfor %}{% endautoescape %}",
    "{% set s = namespace() %}{% set s.s = s %}{{ s }}",
    "{% set s = namespace() %}{% set s.s = [{'a': s}] %}{{ s }}",
    "{% set s = namespace(a=namespace()) %}",
    "{{ range(99999)|map('indent', 100000, true)|list|length }}",
    "{{ range(9999)|map('string')|sum(start='') }}{{ (range(9999)|list * 99)|map('string')|sum(start='') }}",
    "{% from '_self.md' import x %}",
    "{% block b %}{{ self.b() }}{{ self.b() }}{% endblock %}",
];

/// What must not be refused: as much as a long prompt takes.
const USUAL: &[(&str, &str)] = &[
    ("{{ 'a' ~ 1 ~ 'b' + 'c' }}", "a1bc"),
    (
        "{{ 2 * 3 + 4 * 1.5 - 1 }} {{ 7 // 2 }} {{ 2 ** 10 }} {{ -3 % 5 }}",
        "11.0 3 1024 2",
    ),
    (
        "{{ '-' * 10 }}{{ [1] * 3 }}{{ 3 * '=' }}",
        "----------[1, 1, 1]===",
    ),
    (
        "{{ [1, 2] + [3] }}{{ ([1] + [2])[0] }}{{ (1, 2)[1:] }}",
        "[1, 2, 3]1(2,)",
    ),
    (
        "{{ {'a': {'b': 1}}.a.b }}{{ {'a': {'b': 1}} }}",
        "1{'a': {'b': 1}}",
    ),
    (
        "{% if 1 < 2 < 3 and not false or x %}yes{% elif 2 %}no{% else %}never{% endif %}",
        "yes",
    ),
    (
        "{% for i in range(3) if i != 1 %}{{ loop.index }}:{{ i }} {% else %}none{% endfor %}",
        "1:0 2:2",
    ),
    (
        "{% set a, b = 1, 2 %}{{ a }}{{ b }}{% with (c, d) = (3, 4), e = 5 %}{{ c }}{{ d }}{{ e }}{% endwith %}",
        "12345",
    ),
    (
        "{% set s = namespace(n=0) %}{% for i in [1, 2, 3] %}{% set s.n = s.n + i %}{% endfor %}{{ s.n }}",
        "6",
    ),
    (
        "{% macro m(a, b='-') %}<{{ a }}{{ b }}{{ caller() if caller is defined }}>{% endmacro %}{{ m(1) }}{% call m(1, b='+') %}in{% endcall %}",
        "<1-><1+in>",
    ),
    (
        "{% raw %}{{ x }} {% if %}{% endraw %}{ {a} {'b'}",
        "{{ x }} {% if %}{ {a} {'b'}",
    ),
    ("a  {#- gone #}\n {{- 1 -}} \n b", "a1b"),
    (
        "{{ 'a,b'|split(',')|join('+')|upper|replace('A', 'é') }}",
        "é+B",
    ),
    (
        "{{ ['b', 'a']|sort|first }}{{ [3, 1]|min }}{{ 'x' is defined }}{{ 3 is divisibleby 3 }}",
        "a1TrueTrue",
    ),
    (
        "{% filter upper|trim %} a {% endfilter %}{% set c | trim %} b {% endset %}{{ c }}",
        "Ab",
    ),
    (
        "{{ 1 if false }}{{ 'a' if true else 'b' }}{{ nothing|default('d') }}",
        "ad",
    ),
    (
        "{{ '%s is %.2f'|format('pi', 3.14159) }}{{ 'a\nb'|indent(2) }}",
        "pi is 3.14a\n  b",
    ),
    (
        "{% include '_f.md' %}{% import '_m.md' as m %}{{ m.twice('a') }}{% from '_m.md' import twice as t %}{{ t('b') }}",
        "fragmentaabb",
    ),
    (
        "{{ 'q\"\\'\\n\\u00e9'|length }}{{ \"a\" \"b\" }}{{ 1e3 }}{{ 1_000 }}{{ 0x10 }}",
        "5ab1000.0100016",
    ),
];

fn fragments() -> BTreeMap<String, String> {
    let all = [
        ("_f.md", "fragment"),
        ("_self.md", "{% include '_self.md' %}"),
        (
            "_twice.md",
            "{% include '_twice.md' %}{% include '_twice.md' %}x",
        ),
        ("_m.md", "{% macro twice(x) %}{{ x }}{{ x }}{% endmacro %}"),
    ];
    all.map(|(name, text)| (name.to_string(), text.to_string()))
        .into()
}

fn fill(body: &str) -> Result<String, RenderError> {
    let source = format!(
        "+++\nname = \"t\"\nversion = \"1\"\ntask = \"collision\"\nframe = \"ego\"\n+++\n{{% block system %}}{{% endblock %}}{{% block user %}}\n{body}\n{{% endblock %}}"
    );
    let values = BTreeMap::from([
        ("description", "a word or two, ".repeat(10_000)),
        ("x", "1".into()),
    ]);
    let known = Template::read(&source).map_err(|error| RenderError {
        file: "t.md".into(),
        line: Some(1),
        message: error.to_string(),
    });
    known
        .and_then(|_| render("t.md", &source, &fragments(), values))
        .map(|p| p.user)
}

/// What a filling gives, and the most memory that it takes.
fn measured(body: &str) -> (Result<String, RenderError>, usize, Duration) {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let begun = Instant::now();
    let filled = fill(body);
    let peak = MEMORY.peak_usage().saturating_sub(before);
    (filled, peak, begun.elapsed())
}

/// Sources that the parser or compiler would follow until the stack ends.
fn deep() -> Vec<String> {
    let n = 200_000;
    vec![
        format!("{{{{ {}1 }}}}", "-".repeat(n)),
        format!("{{{{ {}1 }}}}", "- ".repeat(n / 2)),
        format!("{{{{ {}1 }}}}", "not ".repeat(n)),
        format!("{{{{ 1{} }}}}", " + 1".repeat(n)),
        format!("{{{{ x{} }}}}", " ~ x".repeat(n)),
        format!("{{{{ x{} }}}}", ".a".repeat(n)),
        format!("{{{{ x{} }}}}", "|upper".repeat(n / 2)),
        format!("{{{{ x{} }}}}", "|replace('a', 'b')".repeat(n / 10)),
        format!("{{{{ x{} }}}}", "[0]".repeat(n)),
        format!("{{{{ x{} }}}}", "()".repeat(n)),
        format!("{{{{ x{} }}}}", " is string".repeat(n / 10)),
        format!("{{{{ 1{} }}}}", " if x else 1".repeat(n / 10)),
        format!("{{{{ 1{} }}}}", " < 1 == 1".repeat(n / 10)),
        format!("{{{{ {}{} }}}}", "(".repeat(n), ")".repeat(n)),
        format!("{{{{ {}{} }}}}", "[".repeat(n), "]".repeat(n)),
        format!("{{{{ {}1{} }}}}", "{1:".repeat(n), "}".repeat(n)),
        format!(
            "{{{{ {}1{} }}}}",
            "x(1, -".repeat(n / 10),
            ")".repeat(n / 10)
        ),
        format!(
            "{}{}",
            "{% if x %}".repeat(n / 10),
            "{% endif %}".repeat(n / 10)
        ),
        format!("{{% if x %}}{}{{% endif %}}", "{% elif x %}".repeat(n / 10)),
        format!(
            "{}{}",
            "{% for a in x %}".repeat(n / 20),
            "{% endfor %}".repeat(n / 20)
        ),
        format!("{{% set {}a{} = x %}}", "(".repeat(n), ")".repeat(n)),
        "x".repeat(2 << 20),
    ]
}

/// Sources as deep as the limits allow, or nearly: filled or refused, but the stack is large enough.
fn nearly_too_deep() -> Vec<String> {
    let n = 990;
    vec![
        format!("{{{{ {}1 }}}}", "-".repeat(n)),
        format!("{{{{ {}1 }}}}", "not ".repeat(n)),
        format!("{{{{ 1{} }}}}", " + 1".repeat(n / 2)),
        format!("{{{{ x{} }}}}", " ~ x".repeat(n / 2)),
        format!("{{{{ x{} }}}}", ".a".repeat(n / 2)),
        format!("{{{{ x{} }}}}", "|upper".repeat(n / 2)),
        format!("{{{{ x{} }}}}", "[0]".repeat(n / 3)),
        format!("{{{{ 1{} }}}}", " if x else 1".repeat(n / 4)),
        format!("{{{{ {}1{} }}}}", "(".repeat(74), ")".repeat(74)),
        format!("{{{{ {}1{} }}}}", "[".repeat(74), "]".repeat(74)),
        format!("{{% if x %}}{}{{% endif %}}", "{% elif x %}a".repeat(n)),
        format!("{}{}", "{% if x %}".repeat(140), "{% endif %}".repeat(140)),
        format!(
            "{}{}",
            "{% for a in [1] %}".repeat(140),
            "{% endfor %}".repeat(140)
        ),
    ]
}

// One test, as two at once would measure each other.
#[test]
fn filling_takes_bounded_memory_and_ends() {
    let _turn = alone();
    let mut wrong = Vec::new();
    for (body, wanted) in USUAL {
        let (filled, ..) = measured(body);
        if filled.as_deref() != Ok(*wanted) {
            wrong.push(format!("{body}: {filled:?}"));
        }
    }
    for body in nearly_too_deep() {
        let (_, peak, took) = measured(&body);
        assert!(peak < MOST && took < LONGEST, "{body}: {peak} {took:?}");
    }
    let deep = deep();
    let all = ENDLESS
        .iter()
        .copied()
        .chain(deep.iter().map(String::as_str));
    for body in all {
        let shown: String = body.chars().take(90).collect();
        let (filled, peak, took) = measured(body);
        println!(
            "{:>4} MiB {:>5} ms {shown}: {filled:.200?}",
            peak >> 20,
            took.as_millis()
        );
        match filled {
            Err(error) if error.line.is_none() || error.message.len() > 1700 => {
                wrong.push(format!("{shown}: {error}"));
            }
            Err(_) => {}
            Ok(text) => wrong.push(format!("{shown}: filled with {} bytes", text.len())),
        }
        if peak > MOST || took > LONGEST {
            wrong.push(format!("{shown}: {} MiB, {took:?}", peak >> 20));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

//! Rewrites a template from its syntax tree so that every operation is charged, with lines unchanged.
//!
//! The tree is compiled by the engine again as text, since included templates can only be given as text.

use minijinja::machinery::Span;
use minijinja::machinery::ast::{Expr, Macro, Set, Stmt};

use super::filters::{KEPT, PAID, RAW};

/// What the definition of a macro takes whenever it is met, bytes: it keeps the variables that it uses.
const MACRO: usize = 1024;

/// The source that does what `tree`, the parsed `source`, does, and pays for it.
#[must_use]
pub fn rewrite(source: &str, tree: &Stmt<'_>) -> String {
    let mut writer = Writer {
        source,
        out: String::with_capacity(source.len() * 2),
        line: 1,
    };
    writer.statement(tree);
    writer.out
}

/// Writes statements; expressions are in [`super::expressions`].
pub(super) struct Writer<'s> {
    pub(super) source: &'s str,
    out: String,
    line: u32,
}

impl Writer<'_> {
    pub(super) fn put(&mut self, text: &str) {
        self.line += text.bytes().filter(|&byte| byte == b'\n').count() as u32;
        self.out.push_str(text);
    }

    /// Goes on in the line of the source; only between the tokens of a tag.
    pub(super) fn at(&mut self, span: Span) {
        while self.line < span.start_line as u32 {
            self.put("\n");
        }
    }

    fn begin(&mut self, span: Span, keyword: &str) {
        self.put("{% ");
        self.at(span);
        self.put(keyword);
        self.put(" ");
    }

    fn end(&mut self, keyword: &str) {
        self.put("{% ");
        self.put(keyword);
        self.put(" %}");
    }

    fn body(&mut self, statements: &[Stmt<'_>]) {
        for statement in statements {
            self.statement(statement);
        }
    }

    /// Text between tags, which must not begin a tag.
    fn raw(&mut self, text: &str) {
        let mut rest = text;
        while let Some(place) = rest.find('{') {
            let after = &rest[place + 1..];
            let tag = after.is_empty() || after.starts_with(['{', '%', '#']);
            self.put(&rest[..place]);
            self.put(if tag { "{{ \"{\" }}" } else { "{" });
            rest = after;
        }
        self.put(rest);
    }

    fn pay(&mut self, bytes: usize) {
        self.put(&format!("{{{{ {bytes}|{RAW} }}}}"));
    }

    fn statement(&mut self, statement: &Stmt<'_>) {
        match statement {
            Stmt::Template(template) => self.body(&template.children),
            Stmt::EmitExpr(emit) => {
                self.put("{{ ");
                self.at(emit.span());
                self.expression(&emit.expr);
                self.put(" }}");
            }
            Stmt::EmitRaw(raw) => {
                self.pay(raw.raw.len());
                self.raw(raw.raw);
            }
            Stmt::ForLoop(each) => {
                self.begin(each.span(), "for");
                self.target(&each.target, false);
                self.put(" in ");
                self.paid(&each.iter);
                if let Some(condition) = &each.filter_expr {
                    self.put(" if ");
                    self.expression(condition);
                }
                self.put(if each.recursive {
                    " recursive %}"
                } else {
                    " %}"
                });
                self.body(&each.body);
                if !each.else_body.is_empty() {
                    self.end("else");
                    self.body(&each.else_body);
                }
                self.end("endfor");
            }
            Stmt::IfCond(_) => self.condition(statement),
            Stmt::WithBlock(with) => {
                self.begin(with.span(), "with");
                for (place, (target, value)) in with.assignments.iter().enumerate() {
                    self.put(if place > 0 { ", " } else { "" });
                    self.target(target, true);
                    self.put(" = ");
                    self.expression(value);
                }
                self.put(" %}");
                self.body(&with.body);
                self.end("endwith");
            }
            Stmt::Set(set) => {
                self.begin(set.span(), "set");
                self.set(set);
            }
            Stmt::SetBlock(set) => {
                self.begin(set.span(), "set");
                self.target(&set.target, false);
                if let Some(filter) = &set.filter {
                    self.put(" | ");
                    self.expression(filter);
                }
                self.put(" %}");
                self.body(&set.body);
                self.end("endset");
            }
            Stmt::AutoEscape(escape) => {
                self.begin(escape.span(), "autoescape");
                self.expression(&escape.enabled);
                self.put(" %}");
                self.body(&escape.body);
                self.end("endautoescape");
            }
            Stmt::FilterBlock(block) => {
                self.begin(block.span(), "filter");
                self.expression(&block.filter);
                self.put(" %}");
                self.body(&block.body);
                self.end("endfilter");
            }
            Stmt::Block(block) => {
                self.begin(block.span(), "block");
                self.put(block.name);
                self.put(if block.required {
                    " required %}"
                } else {
                    " %}"
                });
                // The body of a required block is blank, and never printed.
                if !block.required {
                    self.body(&block.body);
                }
                self.end("endblock");
            }
            Stmt::Import(import) => {
                self.begin(import.span(), "import");
                self.expression(&import.expr);
                self.put(" as ");
                self.expression(&import.name);
                self.put(" %}");
            }
            Stmt::FromImport(import) => {
                self.begin(import.span(), "from");
                self.expression(&import.expr);
                self.put(" import ");
                for (place, (name, alias)) in import.names.iter().enumerate() {
                    self.put(if place > 0 { ", " } else { "" });
                    self.expression(name);
                    if let Some(alias) = alias {
                        self.put(" as ");
                        self.expression(alias);
                    }
                }
                self.put(" %}");
            }
            Stmt::Extends(extends) => {
                self.begin(extends.span(), "extends");
                self.expression(&extends.name);
                self.put(" %}");
            }
            Stmt::Include(include) => {
                self.begin(include.span(), "include");
                self.paid(&include.name);
                self.put(if include.ignore_missing {
                    " ignore missing %}"
                } else {
                    " %}"
                });
            }
            Stmt::Macro(definition) => {
                self.pay(MACRO);
                self.begin(definition.span(), "macro");
                self.put(definition.name);
                self.parameters(definition);
                self.put(" %}");
                self.body(&definition.body);
                self.end("endmacro");
            }
            Stmt::CallBlock(block) => {
                self.pay(MACRO);
                self.begin(block.span(), "call");
                self.parameters(&block.macro_decl);
                self.put(" ");
                self.call(&block.call);
                self.put(" %}");
                self.body(&block.macro_decl.body);
                self.end("endcall");
            }
            Stmt::Do(statement) => {
                self.begin(statement.span(), "do");
                self.call(&statement.call);
                self.put(" %}");
            }
        }
    }

    /// An `if` with all its `elif`, one after the other as they were: nested, they would exceed the parser's limit.
    fn condition(&mut self, statement: &Stmt<'_>) {
        let mut statement = statement;
        let mut keyword = "if";
        while let Stmt::IfCond(condition) = statement {
            self.put("{% ");
            self.at(condition.span());
            self.put(keyword);
            self.put(" ");
            self.expression(&condition.expr);
            self.put(" %}");
            self.body(&condition.true_body);
            match condition.false_body.as_slice() {
                [] => break,
                [next @ Stmt::IfCond(_)] => {
                    statement = next;
                    keyword = "elif";
                }
                other => {
                    self.end("else");
                    self.body(other);
                    break;
                }
            }
        }
        self.end("endif");
    }

    fn set(&mut self, set: &Set<'_>) {
        self.target(&set.target, false);
        self.put(" = ");
        if into_namespace(&set.target) {
            self.wrapped(&set.expr, KEPT);
        } else {
            self.expression(&set.expr);
        }
        self.put(" %}");
    }

    /// What is assigned to: names, attributes of namespaces, lists of them.
    fn target(&mut self, target: &Expr<'_>, nested: bool) {
        match target {
            Expr::List(list) => {
                self.put(if nested { "(" } else { "" });
                for (place, item) in list.items.iter().enumerate() {
                    self.put(if place > 0 { ", " } else { "" });
                    self.target(item, true);
                }
                self.put(if list.items.len() == 1 { "," } else { "" });
                self.put(if nested { ")" } else { "" });
            }
            other => self.expression(other),
        }
    }

    fn parameters(&mut self, definition: &Macro<'_>) {
        let plain = definition.args.len() - definition.defaults.len();
        self.put("(");
        for (place, name) in definition.args.iter().enumerate() {
            self.put(if place > 0 { ", " } else { "" });
            self.expression(name);
            if let Some(default) = place.checked_sub(plain) {
                self.put("=");
                self.expression(&definition.defaults[default]);
            }
        }
        self.put(")");
    }

    /// The expression, paid for.
    pub(super) fn paid(&mut self, expr: &Expr<'_>) {
        if super::expressions::is_short(expr) {
            self.expression(expr);
        } else {
            self.wrapped(expr, PAID);
        }
    }

    pub(super) fn wrapped(&mut self, expr: &Expr<'_>, filter: &str) {
        self.put("(");
        self.expression(expr);
        self.put("|");
        self.put(filter);
        self.put(")");
    }
}

fn into_namespace(target: &Expr<'_>) -> bool {
    match target {
        Expr::GetAttr(_) => true,
        Expr::List(list) => list.items.iter().any(into_namespace),
        _ => false,
    }
}
